use nalgebra::{DMatrix, DVector};

/// A linear least-squares problem `min ‖R δ + q‖²` (R upper triangular) with bounds on δ.
pub(super) struct Linearised {
    triangle: DMatrix<f64>,
    right: DVector<f64>,
    columns: Vec<usize>,
    count: usize,
    /// Room below and above each free coordinate and its longest step.
    room: Vec<(f64, f64, f64)>,
    /// Column norms of the Jacobian: Marquardt's scaling.
    scale: Vec<f64>,
}

impl Linearised {
    pub(super) fn new(
        jacobian: DMatrix<f64>,
        mut right: DVector<f64>,
        (columns, count, room): (Vec<usize>, usize, Vec<(f64, f64, f64)>),
    ) -> Self {
        let scale: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
        let largest = scale.iter().copied().fold(0.0, f64::max);
        // A column without effect gets a scale of its own, so that damping holds its parameter in place.
        let scale = scale.iter().map(|s| s.max(1e-10 * largest).max(f64::MIN_POSITIVE)).collect();
        let rows = jacobian.ncols().min(jacobian.nrows());
        let decomposition = jacobian.qr();
        decomposition.q_tr_mul(&mut right);
        let right = right.rows(0, rows).into_owned();
        Self { triangle: decomposition.r(), right, columns, count, room, scale }
    }

    /// Damped step over all coordinates and the reduction of χ² that the linear model promises for it.
    ///
    /// Coordinates that would leave their bounds are held there and the others are solved anew: all at once, and one after the other along the
    /// way. The first comes far where many are at their bounds; where a valley runs across the box it may promise a growth, which
    /// the second never does. The step is the one of them that promises more.
    pub(super) fn step(&self, damping: f64) -> (Vec<f64>, f64) {
        let (at_once, all_inside) = self.held_at_once(damping);
        let (mut step, mut promised) = self.cut(at_once);
        if !all_inside {
            let (other, more) = self.cut(self.held_along_the_way(damping));
            if more > promised {
                (step, promised) = (other, more);
            }
        }
        let mut all = vec![0.0; self.count];
        for (k, j) in self.columns.iter().enumerate() {
            all[*j] = step[k];
        }
        (all, promised)
    }

    /// The step cut to the longest one that any coordinate may take, and what it promises.
    fn cut(&self, mut step: DVector<f64>) -> (DVector<f64>, f64) {
        step *= self.room.iter().zip(step.iter()).map(|(r, s)| r.2 / s.abs()).fold(1.0, f64::min);
        let promised = self.right.norm_squared() - (&self.triangle * &step + &self.right).norm_squared();
        (step, promised)
    }

    /// All coordinates that would leave their bounds held there, until the others stay inside; and whether none had to be.
    fn held_at_once(&self, damping: f64) -> (DVector<f64>, bool) {
        let mut held = vec![None; self.columns.len()];
        let mut step = DVector::zeros(self.columns.len());
        // Each pass holds at least one more coordinate: at most as many passes as coordinates.
        for _ in 0..=held.len() {
            step = self.solve(&held, damping);
            let mut inside = true;
            for (k, (low, high, _)) in self.room.iter().enumerate() {
                if held[k].is_none() && (step[k] < *low || step[k] > *high) {
                    held[k] = Some(step[k].clamp(*low, *high));
                    inside = false;
                }
            }
            if inside {
                break;
            }
        }
        (step, held.iter().all(Option::is_none))
    }

    /// From no step towards the best one up to the first bound, and on from there with that coordinate held: no part of the way leads uphill.
    fn held_along_the_way(&self, damping: f64) -> DVector<f64> {
        let mut held = vec![None; self.columns.len()];
        let mut step = DVector::zeros(self.columns.len());
        for _ in 0..=held.len() {
            let towards = self.solve(&held, damping) - &step;
            let share = |k: usize| {
                let (low, high, _) = self.room[k];
                let end = if towards[k] < 0.0 { low } else { high };
                (held[k].is_none() && towards[k] != 0.0).then(|| ((end - step[k]) / towards[k]).max(0.0))
            };
            let first = (0..held.len())
                .filter_map(|k| Some((k, share(k)?)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .filter(|(_, share)| *share < 1.0);
            let Some((stopped, share)) = first else { return step + towards };
            step += towards * share;
            held[stopped] = Some(step[stopped]);
        }
        step
    }

    /// `min ‖R δ + q‖² + λ‖D δ‖²` over the coordinates that are not held.
    fn solve(&self, held: &[Option<f64>], damping: f64) -> DVector<f64> {
        let moving: Vec<usize> = (0..held.len()).filter(|k| held[*k].is_none()).collect();
        let mut step = DVector::from_iterator(held.len(), held.iter().map(|h| h.unwrap_or(0.0)));
        if moving.is_empty() {
            return step;
        }
        let rows = self.triangle.nrows();
        let mut matrix = DMatrix::zeros(rows + moving.len(), moving.len());
        let mut right = DVector::zeros(rows + moving.len());
        right.rows_mut(0, rows).copy_from(&(-&self.right - &self.triangle * &step));
        for (column, k) in moving.iter().enumerate() {
            matrix.view_mut((0, column), (rows, 1)).copy_from(&self.triangle.column(*k));
            matrix[(rows + column, column)] = damping.sqrt() * self.scale[*k];
        }
        let decomposition = matrix.qr();
        decomposition.q_tr_mul(&mut right);
        let head = right.rows(0, moving.len()).into_owned();
        if let Some(solution) = decomposition.r().solve_upper_triangular(&head) {
            for (column, k) in moving.iter().enumerate() {
                step[*k] = solution[column];
            }
        }
        step
    }
}
