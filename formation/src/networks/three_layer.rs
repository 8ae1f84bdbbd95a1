//! The network with one hidden layer, both of whose weight matrices are tuned: `Ê = Ŵᵀ tanh(Ĵᵀ y)`. (5.6)

use nalgebra::SVector;

use crate::math::{SplitMix64, sign};

/// Learning rate of the hidden layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HiddenRate {
    /// The same at every input. (5.14)
    Constant(f64),
    /// The given number over `‖sign(y)‖`; 0 if all inputs are 0. (5.21)
    Normalised(f64),
}

/// Learning rates and leakages of both layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeLayerRates {
    /// η1, learning rate of Ŵ.
    pub outer: f64,
    /// η2, leakage of Ŵ per unit of the error that tunes it.
    pub outer_leak: f64,
    /// Learning rate of Ĵ.
    pub hidden: HiddenRate,
    /// η4, leakage of Ĵ per unit of the error that tunes it.
    pub hidden_leak: f64,
}

/// A network from `P` inputs over some hidden neurons to `D` outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ThreeLayer<const P: usize, const D: usize> {
    /// Ŵ: what each hidden neuron contributes to the outputs.
    outer: Vec<SVector<f64, D>>,
    /// Ĵ: how each hidden neuron weighs the inputs.
    hidden: Vec<SVector<f64, P>>,
    /// T = tanh(Ĵᵀ y) of the last response.
    activation: Vec<f64>,
    /// y of the last response.
    input: SVector<f64, P>,
}

impl<const P: usize, const D: usize> ThreeLayer<P, D> {
    /// The network of `agent` (from 0): Ŵ = 0, Ĵ random in [-1, 1).
    ///
    /// All agents draw from one stream, the first agent first, each matrix row by row (a row belongs to an input), so what an
    /// agent gets does not depend on which process it runs in.
    pub fn seeded(seed: u64, agent: usize, neurons: usize) -> Self {
        let mut stream = SplitMix64::new(seed);
        for _ in 0..agent * P * neurons {
            stream.next_bits();
        }
        let mut hidden = vec![SVector::<f64, P>::zeros(); neurons];
        for row in 0..P {
            for neuron in &mut hidden {
                neuron[row] = stream.symmetric();
            }
        }
        Self { outer: vec![SVector::zeros(); neurons], hidden, activation: vec![0.0; neurons], input: SVector::zeros() }
    }

    /// Ê, the response to the input y; remembered for [`ThreeLayer::learn`].
    pub fn respond(&mut self, input: &SVector<f64, P>) -> SVector<f64, D> {
        self.input = *input;
        let mut output = SVector::zeros();
        for ((neuron, weights), activation) in self.hidden.iter().zip(&self.outer).zip(&mut self.activation) {
            *activation = libm::tanh(neuron.dot(input));
            output += *activation * weights;
        }
        output
    }

    /// One explicit Euler step of `dt` seconds, driven by `error` at the input of the last response. (5.12), (5.14), (5.20), (5.21)
    pub fn learn(&mut self, dt: f64, rates: &ThreeLayerRates, error: &SVector<f64, D>) {
        let norm = error.norm();
        let signs = self.input.map(sign);
        let rate = match rates.hidden {
            HiddenRate::Constant(rate) => rate,
            HiddenRate::Normalised(rate) => {
                let length = signs.norm();
                if length == 0.0 { 0.0 } else { rate / length }
            }
        };
        let neurons = self.hidden.iter_mut().zip(&mut self.outer).zip(&self.activation);
        for ((neuron, weights), &activation) in neurons {
            // The hidden layer sees the old outer weights.
            let blame = weights.dot(error) * (1.0 - activation * activation);
            *neuron += dt * (rate * blame * signs - rates.hidden_leak * norm * *neuron);
            *weights += dt * (rates.outer * activation * error - rates.outer_leak * norm * *weights);
        }
    }

    /// Frobenius norm of Ŵ.
    pub fn outer_norm(&self) -> f64 {
        self.outer.iter().map(SVector::norm_squared).sum::<f64>().sqrt()
    }

    /// Frobenius norm of Ĵ.
    pub fn hidden_norm(&self) -> f64 {
        self.hidden.iter().map(SVector::norm_squared).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector1, Vector2};
    use proptest::prelude::*;

    const RATES: ThreeLayerRates =
        ThreeLayerRates { outer: 15.0, outer_leak: 0.1, hidden: HiddenRate::Normalised(0.1), hidden_leak: 0.06 };

    #[test]
    fn first_agent_gets_the_start_of_the_stream() {
        let network = ThreeLayer::<6, 3>::seeded(17, 0, 5);
        let rows = [
            (0, [0.00404238, -0.217132642, -0.343340371, -0.552207614, -0.96548195]),
            (3, [-0.925499856, 0.975112664, -0.150639658, -0.669725971, -0.888099056]),
            (5, [-0.033360067, -0.004720582, 0.656736192, -0.727920216, 0.898712851]),
        ];
        for (row, values) in rows {
            for (neuron, value) in network.hidden.iter().zip(values) {
                assert!((neuron[row] - value).abs() < 1e-9, "row {row}: {} {value}", neuron[row]);
            }
        }
    }

    proptest! {
        #[test]
        fn agents_share_one_stream(seed in 0..1000u64, agents in 1..6usize, neurons in 1..9usize) {
            let mut stream = SplitMix64::new(seed);
            for agent in 0..agents {
                let network = ThreeLayer::<6, 3>::seeded(seed, agent, neurons);
                for row in 0..6 {
                    for neuron in &network.hidden {
                        prop_assert_eq!(neuron[row], stream.symmetric());
                    }
                }
            }
        }

        #[test]
        fn the_response_is_bounded_by_the_outer_weights(y in -9.0..9.0f64, e in -3.0..3.0f64, seed in 0..99u64) {
            let mut network = ThreeLayer::<1, 1>::seeded(seed, 0, 4);
            for _ in 0..50 {
                network.respond(&Vector1::new(y));
                network.learn(0.01, &RATES, &Vector1::new(e));
            }
            let limit: f64 = network.outer.iter().map(|weights| weights[0].abs()).sum();
            prop_assert!(network.respond(&Vector1::new(y))[0].abs() <= limit);
        }

        #[test]
        fn without_an_error_nothing_changes(y in -9.0..9.0f64, seed in 0..99u64) {
            let mut network = ThreeLayer::<2, 2>::seeded(seed, 1, 3);
            network.respond(&Vector2::new(y, 1.0));
            network.learn(0.1, &RATES, &Vector2::new(0.3, -0.2));
            let before = network.clone();
            network.learn(0.1, &RATES, &Vector2::zeros());
            prop_assert_eq!(before, network);
        }
    }

    /// Two steps with one neuron, worked by hand.
    #[test]
    fn hidden_layer_learns_with_the_old_outer_weights() {
        let mut network = ThreeLayer::<2, 1>::seeded(1, 0, 1);
        network.hidden[0] = Vector2::new(0.5, -0.25);
        network.outer[0] = Vector1::new(2.0);
        let t = libm::tanh(0.5 * 1.0 + 0.25 * 2.0);
        assert_eq!(network.respond(&Vector2::new(1.0, -2.0)), Vector1::new(2.0 * t));
        network.learn(0.1, &RATES, &Vector1::new(-3.0));
        let blame = 0.1 / 2f64.sqrt() * 2.0 * -3.0 * (1.0 - t * t);
        let expected = [0.5 + 0.1 * (blame - 0.06 * 3.0 * 0.5), -0.25 + 0.1 * (-blame + 0.06 * 3.0 * 0.25)];
        assert!((network.hidden[0] - Vector2::from(expected)).norm() < 1e-15, "{}", network.hidden[0]);
        let outer = 2.0 + 0.1 * (15.0 * t * -3.0 - 0.1 * 3.0 * 2.0);
        assert!((network.outer[0][0] - outer).abs() < 1e-15);
    }

    #[test]
    fn inputs_that_are_all_zero_do_not_teach_the_hidden_layer() {
        let rates = ThreeLayerRates { hidden_leak: 0.0, ..RATES };
        let mut network = ThreeLayer::<2, 1>::seeded(1, 0, 2);
        let before = network.hidden.clone();
        network.respond(&Vector2::zeros());
        network.learn(0.1, &rates, &Vector1::new(1.0));
        assert_eq!(network.hidden, before);
    }
}
