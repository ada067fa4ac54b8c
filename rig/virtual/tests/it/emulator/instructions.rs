//! Every instruction, its answer, and its refusals.

use super::Bench;
use hysteron_rig::bus::xl430::*;

const BROADCAST: u8 = 0xfe;

#[test]
fn ping_returns_model_and_firmware() {
    let mut bench = Bench::new();
    assert_eq!(bench.ask(3, 1, &[]).unwrap(), (false, vec![0x24, 0x04, 45]));
    bench.say(9, 1, &[]);
    assert!(bench.is_silent());
}

#[test]
fn all_answer_a_broadcast_ping_in_order_of_their_ids() {
    let mut bench = Bench::new();
    bench.write(1, ID, 40).unwrap();
    bench.say(BROADCAST, 1, &[]);
    let ids: Vec<u8> = (0..4).map(|_| bench.hear().0).collect();
    assert_eq!(ids, [2, 3, 4, 40]);
    assert!(bench.is_silent());
}

#[test]
fn what_is_written_is_read_in_every_size() {
    let mut bench = Bench::new();
    for (register, value) in [(LED, 1), (POSITION_P_GAIN, 900), (PROFILE_VELOCITY, 123), (HOMING_OFFSET, -50)]
    {
        bench.write(2, register, value).unwrap();
        assert_eq!(bench.read(2, register), value);
    }
    assert_eq!(bench.read(1, POSITION_P_GAIN), 640);
}

#[test]
fn refusals_carry_the_numbers_of_the_protocol() {
    let mut bench = Bench::new();
    assert_eq!(bench.write(1, OPERATING_MODE, 9), Err(4));
    assert_eq!(bench.write(1, GOAL_POSITION, 5000), Err(6));
    assert_eq!(bench.write(1, PRESENT_POSITION, 0), Err(7));
    assert_eq!(bench.ask(1, 3, &[116, 0, 1]), Err(5));
    assert_eq!(bench.ask(1, 3, &[116]), Err(5));
    assert_eq!(bench.ask(1, 2, &[0xff, 0x0f, 1, 0]), Err(7));
    assert_eq!(bench.ask(1, 0x20, &[]), Err(2));
    bench.torque(true);
    assert_eq!(bench.write(1, RETURN_DELAY, 0), Err(7));
    bench.torque(false);
    assert_eq!(bench.write(1, RETURN_DELAY, 0), Ok(false));
}

#[test]
fn a_wrong_checksum_is_answered_by_its_number() {
    let mut bench = Bench::new();
    let wrong = [0xff, 0xff, 0xfd, 0, 1, 3, 0, 1, 0x19, 0x4f];
    bench.host.serial_port().write_all(&wrong).unwrap();
    assert_eq!(bench.hear().1, Err(3));
    assert_eq!(bench.emulator.counts().bad_packets, 1);
}

#[test]
fn sync_write_and_sync_read_reach_all() {
    let mut bench = Bench::new();
    let mut goals = vec![116, 0, 4, 0];
    for id in 1..=4u8 {
        goals.push(id);
        goals.extend((2000 + i32::from(id)).to_le_bytes());
    }
    bench.say(BROADCAST, 0x83, &goals);
    bench.say(BROADCAST, 0x82, &[116, 0, 4, 0, 4, 2, 1, 3]);
    for id in [4, 2, 1, 3] {
        assert_eq!(bench.hear(), (id, Ok((false, (2000 + i32::from(id)).to_le_bytes().to_vec()))));
    }
    bench.wait_for("a round", |bench| bench.emulator.counts().complete_rounds == 1);
}

#[test]
fn behind_a_missing_servo_a_sync_read_falls_silent() {
    let mut bench = Bench::new();
    bench.say(BROADCAST, 0x82, &[132, 0, 4, 0, 1, 7, 2]);
    assert_eq!(bench.hear().0, 1);
    assert!(bench.is_silent());
    assert_eq!(bench.emulator.counts().broken_rounds, 1);
}

#[test]
fn bulk_read_and_bulk_write_take_each_servo_for_itself() {
    let mut bench = Bench::new();
    bench.say(BROADCAST, 0x93, &[1, 65, 0, 1, 0, 1, 3, 84, 0, 2, 0, 0x84, 3]);
    bench.say(BROADCAST, 0x92, &[3, 84, 0, 2, 0, 1, 64, 0, 2, 0]);
    assert_eq!(bench.hear(), (3, Ok((false, vec![0x84, 3]))));
    assert_eq!(bench.hear(), (1, Ok((false, vec![0, 1]))));
}

#[test]
fn fast_sync_read_is_one_packet_with_a_checksum_after_each_part() {
    let mut bench = Bench::new();
    bench.say(BROADCAST, 0x8a, &[0, 0, 2, 0, 1, 2]);
    let (id, answer) = bench.hear();
    let (_, parts) = answer.unwrap();
    assert_eq!(id, BROADCAST);
    // The first error byte is the error of the packet, the last checksum is its checksum.
    assert_eq!(parts[..3], [1, 0x24, 0x04]);
    assert_eq!(parts[5..], [0, 2, 0x24, 0x04]);
}

#[test]
fn indirect_data_reads_and_writes_several_registers_at_once() {
    let mut bench = Bench::new();
    for (addresses, data) in [(INDIRECT_ADDRESS, INDIRECT_DATA), (INDIRECT_ADDRESS_2, INDIRECT_DATA_2)] {
        let pointers: Vec<u8> =
            [112u16, 113, 114, 115, 144, 145, 146].into_iter().flat_map(u16::to_le_bytes).collect();
        bench.ask(2, 3, &[&addresses.address.to_le_bytes()[..], &pointers].concat()).unwrap();
        bench.write(2, ControlRegister { address: data.address, size: 4 }, 77).unwrap();
        assert_eq!(bench.read(2, PROFILE_VELOCITY), 77);
        let [low, high] = data.address.to_le_bytes();
        let (_, bytes) = bench.ask(2, 2, &[low, high, 7, 0]).unwrap();
        assert_eq!(bytes, [77, 0, 0, 0, 120, 0, 30]);
    }
}

#[test]
fn a_registered_write_waits_for_the_action() {
    let mut bench = Bench::new();
    bench.ask(1, 4, &[65, 0, 1]).unwrap();
    assert_eq!((bench.read(1, LED), bench.read(1, REGISTERED)), (0, 1));
    bench.say(BROADCAST, 5, &[]);
    assert_eq!((bench.read(1, LED), bench.read(1, REGISTERED)), (1, 0));
    assert_eq!(bench.ask(1, 4, &[132, 0, 1, 0, 0, 0]), Err(7));
    assert_eq!(bench.ask(1, 5, &[]), Err(1));
}

#[test]
fn a_reboot_forgets_ram_and_torque_and_is_silent_for_a_while() {
    let mut bench = Bench::new();
    bench.write(1, RETURN_DELAY, 1).unwrap();
    bench.torque(true);
    bench.write(1, PROFILE_VELOCITY, 50).unwrap();
    bench.ask(1, 8, &[]).unwrap();
    assert_eq!(bench.emulator.torque_on(), [false, true, true, true]);
    bench.say(1, 1, &[]);
    assert!(bench.is_silent());
    bench.wait_awake(1);
    assert_eq!(bench.read(1, PROFILE_VELOCITY), 0);
    assert_eq!(bench.read(1, TORQUE_ENABLE), 0);
    assert_eq!(bench.read(1, RETURN_DELAY), 1);
}

#[test]
fn a_factory_reset_keeps_the_requested_registers() {
    let mut bench = Bench::new();
    bench.write(2, SHUTDOWN, 0).unwrap();
    bench.ask(2, 6, &[2]).unwrap();
    bench.wait_awake(2);
    assert_eq!((bench.read(2, SHUTDOWN), bench.read(2, RETURN_DELAY)), (52, 250));
    assert_eq!(bench.ask(2, 6, &[9]), Err(4));
}

#[test]
fn the_status_return_level_and_the_secondary_id_decide_who_answers() {
    let mut bench = Bench::new();
    bench.write(1, SECONDARY_ID, 9).unwrap();
    bench.say(9, 3, &[65, 0, 1]);
    assert!(bench.is_silent());
    assert_eq!(bench.read(1, LED), 1);
    bench.write(1, STATUS_RETURN, 1).unwrap();
    bench.say(1, 3, &[65, 0, 0]);
    assert!(bench.is_silent());
    assert_eq!(bench.read(1, LED), 0);
    bench.say(1, 3, &[68, 0, 0]);
    bench.say(1, 2, &[65, 0, 1, 0]);
    assert!(bench.is_silent());
    bench.ask(1, 1, &[]).unwrap();
}
