//! The residual over two quantities at once: where in the period, at which level, in which sensor it lives.

use crate::Exhibit;

/// Cells of a period: six samples each.
const CELLS: usize = 40;

/// What a map is drawn over.
#[derive(Clone, Debug, PartialEq)]
pub struct MapAxis {
    /// The quantity.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Centres of the cells.
    pub centre: Vec<f64>,
}

/// Quadratic means of the residual over two quantities, in standard deviations of the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualMap {
    /// The quantity across.
    pub across: MapAxis,
    /// The quantity upwards.
    pub up: MapAxis,
    /// With the declared model and with the effects: a row for each centre upwards.
    pub residual: [Vec<Vec<f64>>; 2],
}

/// Maps over phase and level, phase and sensor, sensor and level; none without exhibits.
#[must_use]
pub fn maps(shown: &[Exhibit]) -> Vec<ResidualMap> {
    let mut order: Vec<&Exhibit> = shown.iter().collect();
    order.sort_by(|a, b| a.traces.mean_square.total_cmp(&b.traces.mean_square));
    let Some(first) = order.first() else { return Vec::new() };
    let count = first.residual[0].len();
    let centre = order.iter().map(|exhibit| exhibit.traces.mean_square.sqrt()).collect();
    let level = MapAxis { name: "level", unit: "m/s² RMS of all sensors", centre };
    let sensor =
        MapAxis { name: "sensor", unit: "index", centre: (0..count).map(|sensor| sensor as f64).collect() };
    let phase = MapAxis {
        name: "phase",
        unit: "periods",
        centre: (0..CELLS).map(|cell| (cell as f64 + 0.5) / CELLS as f64).collect(),
    };
    let by_level = [0, 1].map(|side| order.iter().map(|e| cells(&[&e.traces.residual[side]])).collect());
    let of_sensor = |side: usize, sensor: usize| {
        cells(&order.iter().map(|e| &e.traces.sensors[side][sensor]).collect::<Vec<_>>())
    };
    let by_sensor = [0, 1].map(|side| (0..count).map(|sensor| of_sensor(side, sensor)).collect());
    let by_both = [0, 1].map(|side| order.iter().map(|exhibit| exhibit.residual[side].clone()).collect());
    vec![
        ResidualMap { across: phase.clone(), up: level.clone(), residual: by_level },
        ResidualMap { across: phase, up: sensor.clone(), residual: by_sensor },
        ResidualMap { across: sensor, up: level, residual: by_both },
    ]
}

/// Quadratic means over the samples of each cell of a period, and over all that is given.
fn cells(series: &[&Vec<f64>]) -> Vec<f64> {
    let mut sums = [(0.0, 0.0); CELLS];
    for values in series {
        for (t, value) in values.iter().enumerate() {
            let (sum, count) = &mut sums[t * CELLS / values.len()];
            (*sum, *count) = (*sum + value * value, *count + 1.0);
        }
    }
    sums.iter().map(|(sum, count)| f64::sqrt(sum / count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exhibit::Traces;

    /// A residual in the first quarter of the period, in sensor 1, of the loud run: bright there and dark elsewhere.
    #[test]
    fn a_map_shows_where_it_lives() {
        let quiet = vec![1.0; 240];
        let loud: Vec<f64> = (0..240).map(|t| if t < 60 { 9.0 } else { 1.0 }).collect();
        let run = |run: usize, mean_square: f64, second: &Vec<f64>| Exhibit {
            run,
            residual: [vec![1.0, second[0]], vec![1.0, 1.0]],
            traces: Traces {
                residual: [second.clone(), quiet.clone()],
                sensors: [vec![quiet.clone(), second.clone()], vec![quiet.clone(), quiet.clone()]],
                mean_square,
                ..Traces::default()
            },
            ..Exhibit::default()
        };
        // The louder run was measured first: rows are in the order of levels all the same.
        let found = maps(&[run(0, 100.0, &loud), run(1, 4.0, &quiet)]);
        assert_eq!(found[0].up.centre, [2.0, 10.0]);
        assert_eq!(found[0].residual[0][1][..11], [9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 1.0]);
        assert!(found[0].residual[0][0].iter().all(|r| *r == 1.0));
        // Two runs share a sensor's cell: √((9² + 1²)/2).
        assert_eq!(found[1].residual[0][1][0], 41.0_f64.sqrt());
        assert_eq!(found[2].residual[0], [[1.0, 1.0], [1.0, 9.0]]);
        assert!(found.iter().all(|map| map.residual[1].iter().flatten().all(|r| *r == 1.0)));
        assert!(maps(&[]).is_empty());
    }
}
