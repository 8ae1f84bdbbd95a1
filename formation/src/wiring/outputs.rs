//! The outputs of a component: name, length, unit and value of each stand together, once.

use lockstep::{Field, Io, Slice};
use nalgebra::SVector;

use super::{Bind, Refusal};

/// Writes one value of a result.
type Write<R> = Box<dyn Fn(&R, &mut [f64]) + Send + Sync>;

/// What a component publishes for an agent: a table of signals with their values in the result `R` of a step.
///
/// [`Component::outputs`](super::Component::outputs) gives its [`fields`](Outputs::fields);
/// [`Component::build`](super::Component::build) binds it, and the participant writes its result at every step.
///
/// ```
/// use formation::nalgebra::Vector3;
/// use formation::wiring::Outputs;
///
/// struct Tracking {
///     error: Vector3<f64>,
///     level: f64,
/// }
///
/// let outputs = Outputs::new()
///     .vector("error", "m, m, rad", |tracking: &Tracking| tracking.error)
///     .scalar("level", "", |tracking| tracking.level);
/// let fields = outputs.fields();
/// assert_eq!((fields[0].name.as_str(), fields[0].shape.words(), fields[1].name.as_str()), ("error", 3, "level"));
/// ```
pub struct Outputs<R> {
    signals: Vec<Signal<R>>,
}

struct Signal<R> {
    field: Field,
    /// Length of what `write` writes.
    length: usize,
    write: Write<R>,
}

/// The [`Outputs`] of a participant, which writes them.
pub struct BoundOutputs<R> {
    signals: Vec<(Slice, Write<R>)>,
}

impl<R> Default for Outputs<R> {
    fn default() -> Self {
        Self { signals: Vec::new() }
    }
}

impl<R> Outputs<R> {
    /// A table without signals.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a signal of `D` numbers.
    pub fn vector<const D: usize>(
        self,
        name: &str,
        unit: &str,
        value: impl Fn(&R) -> SVector<f64, D> + Send + Sync + 'static,
    ) -> Self {
        self.field(Field::vector(name, D, unit), value)
    }

    /// Adds a signal of one number.
    pub fn scalar(self, name: &str, unit: &str, value: impl Fn(&R) -> f64 + Send + Sync + 'static) -> Self {
        self.field(Field::scalar(name, unit), move |result| SVector::<f64, 1>::new(value(result)))
    }

    /// Adds a signal of a length that is known when the component is built; `write` writes all of it.
    pub fn slice(
        self,
        name: &str,
        length: usize,
        unit: &str,
        write: impl Fn(&R, &mut [f64]) + Send + Sync + 'static,
    ) -> Self {
        self.any(Field::vector(name, length, unit), write)
    }

    /// Adds a signal that is described elsewhere; `write` writes all of it.
    pub fn any(self, field: Field, write: impl Fn(&R, &mut [f64]) + Send + Sync + 'static) -> Self {
        let length = field.shape.words();
        self.with(Signal { field, length, write: Box::new(write) })
    }

    /// Adds a signal that is described elsewhere, as the input of a vehicle is by
    /// [`Vehicle::input_field`](crate::vehicle::Vehicle::input_field). Binding refuses it if it has not the length of the value.
    pub fn field<const D: usize>(
        self,
        field: Field,
        value: impl Fn(&R) -> SVector<f64, D> + Send + Sync + 'static,
    ) -> Self {
        let write = move |result: &R, place: &mut [f64]| place.copy_from_slice(value(result).as_slice());
        self.with(Signal { field, length: D, write: Box::new(write) })
    }

    fn with(mut self, signal: Signal<R>) -> Self {
        self.signals.push(signal);
        self
    }

    /// What is declared: name, length and unit of every signal, in order.
    pub fn fields(&self) -> Vec<Field> {
        self.signals.iter().map(|signal| signal.field.clone()).collect()
    }

    /// Finds the place of every signal in the sample of `agent` (from 0).
    ///
    /// # Errors
    /// See [`Bind::out`].
    pub fn bind(self, agent: usize, bind: &Bind) -> Result<BoundOutputs<R>, Refusal> {
        let bound = self.signals.into_iter().map(|Signal { field, length, write }| {
            let place = bind.slice_out(agent, &field.name, length)?;
            Ok((place, write))
        });
        Ok(BoundOutputs { signals: bound.collect::<Result<_, Refusal>>()? })
    }
}

impl<R> BoundOutputs<R> {
    /// Writes all signals of a result. Does not allocate.
    pub fn write(&self, io: &mut Io, result: &R) {
        for (place, write) in &self.signals {
            write(result, io.slice_mut(*place));
        }
    }

    /// Says that the sample is not new; see [`Io::mark_held`].
    pub fn mark_held(&self, io: &mut Io) {
        if let Some((place, _)) = self.signals.first() {
            io.mark_slice_held(*place);
        }
    }
}
