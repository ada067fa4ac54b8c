//! stub
/// stub
pub fn write(_: &std::path::Path, _: &crate::simulate::Run, _: bool) -> anyhow::Result<()> { Ok(()) }
