//! Serves the poses of a tip on a circle over OpenIGTLink: `pose_server PORT DEVICE FORMAT SECONDS`, FORMAT one of
//! `transform`, `status`, `position`, `tools`. Prints its address, and each pose as CSV.
#![allow(clippy::print_stdout)] // its output is what it is for

use hysteron_base::BadInput;
use hysteron_rig::virtual_rig::TrackedPose;
use hysteron_rig::virtual_rig::emulator::{DeviceClock, Format, PoseServer, PoseServerSettings};
use hysteron_rig::{Pose, Quality, Result};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Time between poses [s].
const STEP: f64 = 0.025;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [port, device, format, seconds] = arguments.as_slice() else {
        let expected = "PORT DEVICE FORMAT SECONDS";
        return Err(BadInput::new("arguments", expected, format!("{} of them", arguments.len())).into());
    };
    let port = port.parse().map_err(|_| BadInput::new("PORT", "0 to 65535", port))?;
    let seconds: f64 = seconds.parse().map_err(|_| BadInput::new("SECONDS", "a number", seconds))?;
    let format = match format.as_str() {
        "transform" => Format::Transform,
        "status" => Format::TransformWithStatus,
        "position" => Format::Position,
        "tools" => Format::Tools,
        other => return Err(BadInput::new("FORMAT", "transform, status, position or tools", other).into()),
    };
    // The time of day, as most trackers stamp their poses.
    let offset = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64());
    let clock = DeviceClock { offset, drift: 0.0 };
    let mut server = PoseServer::start(PoseServerSettings { port, device: device.clone(), clock, format })?;
    println!("# {}", server.address());
    println!("stamp_s,x_mm,y_mm,z_mm,qw,qx,qy,qz");
    let start = Instant::now();
    for k in 0.. {
        let due = STEP * f64::from(k);
        while start.elapsed().as_secs_f64() < due {
            std::thread::sleep(Duration::from_millis(1));
            server.poll();
        }
        if due > seconds {
            break;
        }
        let angle = due;
        let position = [0.03 * angle.cos(), 0.03 * angle.sin(), 0.25 + 1e-3 * (7.0 * due).sin()];
        let (qw, qz) = ((0.5 * angle).cos(), (0.5 * angle).sin());
        let pose = Pose { time: due, position, orientation: [qw, 0.0, 0.0, qz], quality: Quality::Good };
        server.send(&TrackedPose { pose, sent_at: due });
        let [x, y, z] = position.map(|x| x * 1e3);
        println!("{},{x},{y},{z},{qw},0,0,{qz}", clock.show(due));
    }
    Ok(())
}
