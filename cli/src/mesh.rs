//! stub
/// Stub
#[derive(Debug, clap::Args)]
pub struct Arguments {}
/// stub
pub fn run(_: &Arguments) -> anyhow::Result<()> { Ok(()) }
