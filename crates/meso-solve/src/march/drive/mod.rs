//! The loop of a test: steps, rows and frames, until the end.

use crate::march::frame::Frame;
use crate::march::observer::Observer;
use crate::march::response::{Ended, Response};
use crate::march::run::{RUNAWAY, Run};
use meso_collision::math::Vec3;
use meso_concrete::watch::{Stage, Watch};
use meso_mesh::Phase;
use meso_trial::{Expansion, Test};

/// Time between rows over that in which a wave crosses the specimen, above which rows miss what happens in it.
const COARSE: f64 = 0.1;

impl Run<'_> {
    /// Goes on to the end of the test, or until the watch stops it or it diverges.
    pub fn to_end(&mut self, watch: &dyn Watch, observer: &dyn Observer) -> Response {
        let ended = self.go(watch, observer).and_then(|ended| self.bring_back().map(|()| ended));
        let ended = ended.unwrap_or_else(Ended::Failed);
        let ended = if let Ended::Diverged(_) = ended { Ended::Diverged(self.culprit()) } else { ended };
        Response::of(self, ended)
    }

    fn go(&mut self, watch: &dyn Watch, observer: &dyn Observer) -> Result<Ended, String> {
        while !self.is_over() {
            let (rows, frames) = (self.rows_due(), self.frames_due());
            self.proceed()?;
            if !self.is_sound() {
                return Ok(Ended::Diverged(String::new()));
            }
            let is_row = self.rows_due() > rows || self.is_over();
            if is_row {
                self.bring_back_energies()?;
                if !self.add_row() {
                    return Ok(Ended::Diverged(String::new()));
                }
            }
            if self.frames_due() > frames {
                self.bring_back()?;
                observer.frame(&Frame::new(self, self.frames_due()));
            }
            if is_row {
                self.report(watch, observer)?;
            }
            // Asked after every step: rows of a large mesh may be seconds apart.
            if watch.stops() {
                return Ok(Ended::Stopped);
            }
        }
        Ok(Ended::Completed)
    }

    fn report(&mut self, watch: &dyn Watch, observer: &dyn Observer) -> Result<(), String> {
        watch.stage(Stage::Solve, self.done());
        if let Some(row) = self.state.rows.last().copied() {
            observer.row(&row, self.done());
            if observer.wants(&row) {
                self.bring_back()?;
                observer.moment(&Frame::new(self, 0));
            }
        }
        if observer.keeps() {
            self.bring_back()?;
            observer.keep(self);
        }
        Ok(())
    }

    fn is_over(&self) -> bool {
        if !self.path.turns.is_empty() {
            return self.path.is_through(&self.state.leg);
        }
        self.state.progress >= self.outline.steps as f64 || self.is_too_far()
    }

    /// Whether strains of a test in real time are no longer small.
    pub(crate) fn is_too_far(&self) -> bool {
        self.supports.is_driven && self.supports.farthest(&self.state.held) > Test::LARGEST_STRAIN
    }

    /// Share of the test's time at full speed that is over.
    fn done(&self) -> f64 {
        if self.is_too_far() { 1.0 } else { (self.state.progress / self.outline.steps as f64).min(1.0) }
    }

    /// Rows due so far.
    fn rows_due(&self) -> u64 {
        let due = |taken: f64| (taken / self.outline.stride as f64) as u64;
        // One more for as many steps of the servo.
        due(self.state.progress) + due(self.state.added) + self.strained()
    }

    /// Rows due by the strain between plates in real time, where those over time would miss the peak: in a test that is planned
    /// longer than its strain allows, and after slow pressures.
    fn strained(&self) -> u64 {
        // Asked twice a step: quasi-static tests are let off first.
        if !self.supports.is_driven {
            return 0;
        }
        let mortar = &self.common.matter[Phase::Mortar.index()].elastic;
        let crossing = self.supports.length_mm / mortar.wave_speed_mm_per_s();
        if self.outline.stride as f64 * self.outline.dt <= COARSE * crossing {
            return 0;
        }
        (self.supports.farthest(&self.state.held) / Test::LARGEST_STRAIN * f64::from(self.test.rows)) as u64
    }

    /// Frames due so far: evenly over the strain of a straight path, else over the time at full speed, the last at its end.
    fn frames_due(&self) -> u32 {
        let frames = self.test.frames;
        if self.done() < 1.0 { (self.frame_share() * f64::from(frames)) as u32 } else { frames }
    }

    /// Share of the test by which frames are due.
    pub(super) fn frame_share(&self) -> f64 {
        self.path.gone(self.state.progress * self.outline.dt).unwrap_or_else(|| self.done()).min(1.0)
    }

    /// Whether energies are finite and the specimen moves no faster than the plates can have made it.
    fn is_sound(&self) -> bool {
        let state = &self.state;
        let energies = [state.internal, state.external, state.friction, state.kinetic];
        let most = RUNAWAY * state.external.abs().max(self.plate_energy());
        energies.iter().all(|energy| energy.is_finite()) && state.kinetic <= most
    }

    /// Kinetic energy of the whole specimen at the speed of a plate, mJ.
    pub(super) fn plate_energy(&self) -> f64 {
        let speeds = self.supports.all.iter().map(|fixture| fixture.moves.abs() * self.path.speed);
        let moved = 0.5 * self.outline.masses[1] * speeds.fold(self.supports.fastest(), f64::max).powi(2);
        moved + self.test.expansion().map_or(0.0, |expansion| self.stored_by(&expansion))
    }

    /// Elastic energy of the whole specimen, were it held while its phases expand, mJ.
    fn stored_by(&self, expansion: &Expansion) -> f64 {
        let stiffest = self.common.matter.iter().map(|matter| matter.elastic.youngs_modulus_mpa).fold(0.0, f64::max);
        let most = expansion.most();
        0.5 * stiffest * most * most * self.sample.volume_mm3
    }

    /// The cell whose nodes are fastest, in words.
    fn culprit(&self) -> String {
        let mesh = self.sample.mesh;
        let mut speed = vec![0.0; self.order.len()];
        for (velocity, &node) in self.nodes.velocity.iter().zip(&self.order) {
            let fast = velocity.iter().fold(0.0_f64, |fast, v| fast.max(v.abs()));
            speed[node as usize] = if velocity.iter().all(|v| v.is_finite()) { fast } else { f64::INFINITY };
        }
        let of_cell = |cell: &[u32]| cell.iter().map(|&node| speed[node as usize]).sum::<f64>();
        let cells = mesh.cells().enumerate().map(|(number, cell)| (number, of_cell(cell)));
        let (number, _) = cells.fold((0, -1.0), |worst, cell| if cell.1 > worst.1 { cell } else { worst });
        let nodes = mesh.cell(number);
        let centre = nodes.iter().map(|&node| mesh.points[node as usize]).sum::<Vec3>();
        let [x, y, z]: [f64; 3] = (centre / nodes.len() as f64).into();
        let phase = mesh.phases.name(mesh.phase[number]);
        format!("element {number} ({phase}) at ({x:.2}, {y:.2}, {z:.2}) mm, step {}", self.state.step)
    }
}

#[cfg(test)]
mod tests;
