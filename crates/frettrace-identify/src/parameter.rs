/// The coordinate in which a parameter is fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// `c = ln p`, for positive parameters whose size is unknown.
    Log,
    /// `c = p / scale`.
    Linear {
        /// A typical change of the parameter, in its unit.
        scale: f64,
    },
}

impl Transform {
    /// Size of a value: its own in the logarithm, else the scale.
    #[must_use]
    pub fn size(self, value: f64) -> f64 {
        match self {
            Self::Log => value.abs(),
            Self::Linear { scale } => scale.abs(),
        }
    }

    /// Coordinate of a physical value.
    #[must_use]
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Log => value.ln(),
            Self::Linear { scale } => value / scale,
        }
    }

    /// Physical value of a coordinate.
    #[must_use]
    pub fn value(self, coordinate: f64) -> f64 {
        match self {
            Self::Log => coordinate.exp(),
            Self::Linear { scale } => coordinate * scale,
        }
    }

    /// `dp/dc` at a physical value.
    #[must_use]
    pub fn slope(self, value: f64) -> f64 {
        match self {
            Self::Log => value,
            Self::Linear { scale } => scale,
        }
    }

    /// Longest step of the coordinate the fit takes at once: a factor e for a logarithm, ten scales otherwise.
    pub(crate) fn longest_step(self) -> f64 {
        match self {
            Self::Log => 1.0,
            Self::Linear { .. } => 10.0,
        }
    }
}

/// A Gaussian prior: what is known of a parameter before the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Mean, in the parameter's unit.
    pub mean: f64,
    /// Standard deviation, in the parameter's unit (of the value near the mean).
    pub std: f64,
}

/// A named parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name as in the result file.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Coordinate of the fit.
    pub transform: Transform,
    /// Lowest and highest admissible value, in the parameter's unit (may be infinite).
    pub bounds: (f64, f64),
    /// Prior, where something is known.
    pub prior: Option<Prior>,
    /// The experiment that tells this parameter, in words.
    pub experiment: String,
}

impl Parameter {
    /// A positive parameter of unknown size, fitted in its logarithm.
    #[must_use]
    pub fn positive(name: &str, unit: &str, bounds: (f64, f64)) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            transform: Transform::Log,
            bounds,
            prior: None,
            experiment: String::new(),
        }
    }

    /// A parameter around a declared value with a known standard deviation.
    #[must_use]
    pub fn declared(name: &str, unit: &str, prior: Prior) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            transform: Transform::Linear { scale: prior.std },
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            prior: Some(prior),
            experiment: String::new(),
        }
    }

    /// Distance of a one-sided difference at a value: a share of its size, downwards where the upper bound is nearer.
    #[must_use]
    pub fn difference(&self, value: f64, share: f64) -> f64 {
        let distance = share * self.transform.size(value);
        if value + distance > self.bounds.1 { -distance } else { distance }
    }

    /// The same parameter with the experiment that tells it.
    #[must_use]
    pub fn told_by(mut self, experiment: &str) -> Self {
        experiment.clone_into(&mut self.experiment);
        self
    }

    /// Bounds in the coordinate of the fit.
    #[must_use]
    pub fn coordinate_bounds(&self) -> (f64, f64) {
        let low = match self.transform {
            Transform::Log if self.bounds.0 <= 0.0 => f64::NEG_INFINITY,
            transform => transform.coordinate(self.bounds.0),
        };
        (low, self.transform.coordinate(self.bounds.1))
    }

    /// Widest half interval, in the coordinate, of a parameter that counts as known.
    ///
    /// `widest` is relative to the value; a prior bounds a parameter at all events.
    pub(crate) fn widest(&self, coordinate: f64, widest: f64) -> f64 {
        match (self.prior, self.transform) {
            (Some(_), _) => f64::INFINITY,
            (None, Transform::Log) => widest,
            (None, Transform::Linear { .. }) => widest * coordinate.abs(),
        }
    }

    /// Whitened residual of the prior and its derivative by the coordinate.
    #[must_use]
    pub fn prior_residual(&self, coordinate: f64) -> Option<(f64, f64)> {
        self.prior.map(|prior| {
            let std = prior.std / self.transform.slope(prior.mean).abs();
            ((coordinate - self.transform.coordinate(prior.mean)) / std, 1.0 / std)
        })
    }
}
