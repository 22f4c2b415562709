//! What of a tick's damaged frames came through.

use firmware::monitor::Thresholds;
use shared::arm::{JOINTS, REFERENCE};
use shared::fault::Mode;
use shared::telemetry::PATH_RATE_ONE;
use shared::wire::biss_c::Layout;
use shared::wire::{ads131m04, dac81404};

use super::{ADC, DAC, Running, TICK_HZ, Tally};
use crate::rig::Way;

impl Running {
    /// Judges the tick that the controller has just taken; `used` says which device's frames it used.
    pub(super) fn judge(
        &mut self,
        used: impl Fn(usize) -> bool,
        tally: &mut Tally,
        limits: &Thresholds,
    ) {
        for j in 0..JOINTS {
            self.judge_encoder(j, used(j), tally, limits);
        }
        self.judge_adc(used(ADC), tally);
        self.judge_dac(used(DAC), tally);
        self.judge_arm(tally);
    }

    fn judge_encoder(&mut self, j: usize, used: bool, tally: &mut Tally, limits: &Thresholds) {
        let layout = Layout::new(REFERENCE.encoders[j].bits).expect("a width that a head has");
        let tap = self.taps[j].borrow();
        let decode = |bytes: &[u8]| layout.decode(bytes.try_into().expect("a whole frame")).ok();
        let sent = decode(&tap.sent).expect("as a head sends it");
        let code = self.rig.last.code[j];
        let off = code.abs_diff(sent.position);
        tally.off_counts[j] = tally.off_counts[j].max(off);
        // No step differs from the one before by more than a joint can be accelerated, in the ticks since the last
        // sample that was used.
        let [before, first] = self.codes[j];
        let bend = code.wrapping_sub(before).wrapping_sub(before.wrapping_sub(first)) as i32;
        let ticks = 1 + u32::from(self.levels[j]) / 2;
        let window = limits.encoder.wide[j] * ticks * ticks;
        // Where that stops the arm, the model alone says where the joint is.
        let fits = !used || !self.goes_on() || bend.unsigned_abs() <= window;
        assert!(fits, "joint {j}: {bend} counts, at most {window}");
        self.codes[j] = [code, before];
        let level = self.levels[j];
        self.levels[j] = if used { level.saturating_sub(1) } else { (level + 2).min(6) };
        let Some((hit, (_, after))) = tap.hit.zip(tap.changed.as_ref()) else { return };
        let fate = &mut tally.fates[0][hit.sort];
        fate.frames += 1;
        let passed = decode(after).is_some_and(|word| word != sent);
        fate.passed += u64::from(passed);
        fate.used += u64::from(passed && used);
        assert!(hit.sort > 1 || !passed && !used, "{hit:?} of encoder {j} is used");
    }

    fn judge_adc(&self, used: bool, tally: &mut Tally) {
        let tap = self.taps[ADC].borrow();
        let decode = |bytes: &[u8]| ads131m04::decode(bytes.try_into().expect("a frame")).ok();
        let newest = decode(&tap.sent).expect("as the converter sends it");
        let right = self.rig.last.adc == newest.codes;
        let Some((hit, (before, after))) = tap.hit.zip(tap.changed.as_ref()) else {
            assert!(!used || right);
            return;
        };
        let fate = &mut tally.fates[1][hit.sort];
        fate.frames += 1;
        let passed = decode(after).is_some_and(|frame| Some(frame) != decode(before));
        fate.passed += u64::from(passed);
        fate.used += u64::from(used && !right);
        assert!(hit.sort > 1 || !passed && (!used || right), "{hit:?} of the converter is used");
    }

    fn judge_dac(&self, used: bool, tally: &mut Tally) {
        let tap = self.taps[DAC].borrow();
        let Some((hit, (before, after))) = tap.hit.zip(tap.changed.as_ref()) else { return };
        let fate = &mut tally.fates[2][hit.sort];
        fate.frames += 1;
        let word = |bytes: &[u8]| u32::from_be_bytes(bytes.try_into().expect("a frame"));
        let changed = word(before) ^ word(after);
        let passed = dac81404::Answer::from_bytes(word(after).to_be_bytes()).is_some();
        fate.passed += u64::from(passed);
        fate.used += u64::from(passed && used);
        // An echo's R/W bit and its CRC say nothing that is not known.
        let harmless = hit.way == Way::In && hit.frame > 0 && changed & 0x7FFF_FF00 == 0;
        // A request for the status is answered in the next tick.
        let later = hit.way == Way::Out && hit.frame == 4;
        assert!(!used || harmless || later || hit.sort > 1, "{hit:?} of the DAC is used");
        assert!(hit.sort > 1 || !passed, "{hit:?} of the DAC passes");
    }

    /// Compares the tip with its path, along which a stop goes on at a falling rate.
    pub(super) fn judge_arm(&mut self, tally: &mut Tally) {
        let record = &self.rig.last;
        match Mode::from_number(record.mode) {
            Some(Mode::Moving) => self.phase = f64::from(record.phase),
            Some(Mode::Stopping) => {
                self.phase += f64::from(record.path_rate) / f64::from(PATH_RATE_ONE);
            }
            _ => {}
        }
        let all = f64::from(self.lift.duration_ticks);
        let tick = if self.down { all - self.phase } else { self.phase };
        let wanted = self.path.tip(&self.path.at(tick / TICK_HZ)).position_m;
        let tip = self.rig.plant.tip().position_m;
        let off = tip.iter().zip(wanted).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        tally.off_path_m = tally.off_path_m.max(off);
    }
}
