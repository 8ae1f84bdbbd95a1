//! `phalanx schema`.

use crate::catalog::Catalog;
use crate::failure::Failure;

pub(crate) fn schema(catalog: &Catalog) -> Result<(), Failure> {
    println!("{:#}", crate::show::schema::schema(catalog));
    Ok(())
}
