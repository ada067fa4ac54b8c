//! Prints the poses of a tracker as CSV: `tracker_listen HOST:PORT DEVICE SECONDS`; `first` for the first device.
#![allow(clippy::print_stdout)] // its output is what it is for

use hysteron_base::BadInput;
use hysteron_rig::Result;
use hysteron_rig::tracker::{Client, TrackerSettings};
use std::time::{Duration, Instant};

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [address, device, seconds] = arguments.as_slice() else {
        let expected = "HOST:PORT DEVICE SECONDS";
        return Err(BadInput::new("arguments", expected, format!("{} of them", arguments.len())).into());
    };
    let seconds: f64 = seconds.parse().map_err(|_| BadInput::new("SECONDS", "a number", seconds))?;
    let start = Instant::now();
    let mut settings = TrackerSettings::new(address);
    settings.device = (device != "first").then(|| device.clone());
    let client = Client::connect(settings, start)?;
    println!("now_s,time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,quality");
    let (mut poses, mut events) = (Vec::new(), Vec::new());
    while start.elapsed().as_secs_f64() < seconds {
        std::thread::sleep(Duration::from_millis(1));
        client.take_poses(&mut poses);
        client.take_events(&mut events);
        let now = start.elapsed().as_secs_f64();
        for pose in poses.drain(..) {
            let ([x, y, z], [qw, qx, qy, qz]) = (pose.position.map(|x| x * 1e3), pose.orientation);
            println!("{now},{},{x},{y},{z},{qw},{qx},{qy},{qz},{:?}", pose.time, pose.quality);
        }
        for event in events.drain(..) {
            println!("# {:.3} s: {:?}: {}", event.time_s, event.kind, event.message);
        }
    }
    println!("# {:?}", client.counts());
    Ok(())
}
