//! Linear systems of a balance without their matrix: GMRES (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7, 1986) with a kept
//! factor before it.
//!
//! Of all `x` in the span of `b, Pb, P²b, …`, `P = M⁻¹J`, `b = M⁻¹d` with the factor `M` of a derivative nearby, it finds the one that leaves the
//! least of `J x = d`. A contact that slides and holds at a few other instants than those of the factor makes `P` the identity but for as
//! many directions, and one product each finds them; a new factor takes as many products as there are unknowns, and their cube. A method
//! of short recurrences (BiCGSTAB) keeps fewer vectors and asks the factor more often, which is what costs here.

/// The solution of `P x = b` whose rest is less than a share `tolerance` of `b`; `None` where `most` products do not find it.
pub(super) fn solve(
    mut product: impl FnMut(&[f64]) -> Vec<f64>,
    right: Vec<f64>,
    (tolerance, most): (f64, usize),
) -> Option<Vec<f64>> {
    let size = norm(&right);
    if size == 0.0 {
        return Some(right);
    }
    let mut space = Space::new(right, size);
    for _ in 0..most {
        let answer = product(space.newest());
        if space.extend(answer) < tolerance * size {
            return Some(space.solution());
        }
    }
    None
}

/// Orthonormal directions, and the least-squares problem in them, triangular by rotations.
struct Space {
    directions: Vec<Vec<f64>>,
    /// Columns of the triangle, one a product.
    triangle: Vec<Vec<f64>>,
    /// Cosine and sine of each rotation.
    rotations: Vec<[f64; 2]>,
    /// The right side in the rotated directions; its last value is the rest.
    rotated: Vec<f64>,
}

impl Space {
    fn new(right: Vec<f64>, size: f64) -> Self {
        let (triangle, rotations) = (Vec::new(), Vec::new());
        Self { directions: vec![scaled(right, size)], triangle, rotations, rotated: vec![size] }
    }

    fn newest(&self) -> &[f64] {
        self.directions.last().map_or(&[], |direction| direction)
    }

    /// Takes in what the newest direction was answered with; what is left of the right side then.
    fn extend(&mut self, mut answer: Vec<f64>) -> f64 {
        let mut column: Vec<f64> = Vec::with_capacity(self.directions.len());
        for direction in &self.directions {
            let along = inner(direction, &answer);
            answer.iter_mut().zip(direction).for_each(|(x, d)| *x -= along * d);
            column.push(along);
        }
        let beyond = norm(&answer);
        self.directions.push(scaled(answer, beyond));
        for (k, [cosine, sine]) in self.rotations.iter().enumerate() {
            let (a, b) = (column[k], column[k + 1]);
            (column[k], column[k + 1]) = (cosine * a + sine * b, cosine * b - sine * a);
        }
        let last = column.len() - 1;
        let length = column[last].hypot(beyond).max(f64::MIN_POSITIVE);
        let (cosine, sine) = (column[last] / length, beyond / length);
        column[last] = length;
        self.triangle.push(column);
        self.rotations.push([cosine, sine]);
        let rest = -sine * self.rotated[last];
        self.rotated[last] *= cosine;
        self.rotated.push(rest);
        rest.abs()
    }

    fn solution(&self) -> Vec<f64> {
        let mut shares = self.rotated[..self.triangle.len()].to_vec();
        for (k, column) in self.triangle.iter().enumerate().rev() {
            shares[k] /= column[k];
            let (above, share) = shares.split_at_mut(k);
            above.iter_mut().zip(column).for_each(|(other, x)| *other -= share[0] * x);
        }
        let mut solution = vec![0.0; self.directions[0].len()];
        for (share, direction) in shares.iter().zip(&self.directions) {
            solution.iter_mut().zip(direction).for_each(|(x, d)| *x += share * d);
        }
        solution
    }
}

pub(super) fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    inner(a, a).sqrt()
}

fn scaled(mut a: Vec<f64>, size: f64) -> Vec<f64> {
    a.iter_mut().for_each(|x| *x /= size.max(f64::MIN_POSITIVE));
    a
}

#[cfg(test)]
mod tests {
    use super::solve;

    /// `P = 1 + u vᵀ + w zᵀ`, two directions beside the identity: three products find the solution, two do not.
    #[test]
    fn a_few_other_directions_take_as_many_products() {
        let n = 50;
        let of = |turn: f64| (0..n).map(move |k| (turn * (k as f64 + 0.3)).sin()).collect::<Vec<f64>>();
        let ([u, v], [w, z]) = ([of(1.1), of(0.7)], [of(2.3), of(1.9)]);
        let product = |x: &[f64]| -> Vec<f64> {
            let (along_v, along_z) = (super::inner(&v, x), super::inner(&z, x));
            x.iter().zip(u.iter().zip(&w)).map(|(x, (u, w))| x + along_v * u + along_z * w).collect()
        };
        let right = of(0.4);
        assert!(solve(product, right.clone(), (1e-10, 2)).is_none());
        let found = solve(product, right.clone(), (1e-10, 3)).expect("three products");
        let left = product(&found).iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(left < 1e-9, "{left:e}");
    }

    #[test]
    fn nothing_asks_for_nothing() {
        assert_eq!(solve(<[f64]>::to_vec, vec![0.0; 4], (1e-2, 1)), Some(vec![0.0; 4]));
    }
}
