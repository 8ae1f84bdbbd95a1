//! `phalanx schema`.

use crate::failure::Failure;

pub(crate) fn schema() -> Result<(), Failure> {
    println!("{:#}", crate::show::schema::schema());
    Ok(())
}
