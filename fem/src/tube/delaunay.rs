//! Delaunay triangulation of points in the plane (Bowyer 1981, Watson 1981).
//!
//! Main decision: the points are snapped to a grid of whole numbers, so every test is exact and the result
//! the same everywhere. The grid only decides who is whose neighbour; the coordinates stay as they are.

/// Grid steps per unit length. The points lie in the unit circle, the helpers at 64: differences stay below
/// 2^29 and the determinants below 2^121.
const GRID: f64 = (1_u32 << 22) as f64;
const FAR: i64 = 64 << 22;

type PlanePoint = [i64; 2];

/// Triangulates points of the unit circle; triangles turn left. Coinciding points are dropped.
pub(super) fn triangulate(points: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let n = points.len() as u32;
    let mut at: Vec<PlanePoint> =
        points.iter().map(|p| p.map(|v| (v.clamp(-1.0, 1.0) * GRID).round() as i64)).collect();
    at.extend([[-FAR, -FAR], [FAR, -FAR], [0, FAR]]);

    let mut triangles = vec![[n, n + 1, n + 2]];
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for p in 0..n {
        edges.clear();
        let x = at[p as usize];
        triangles.retain(|t| {
            let inside = in_circle(t.map(|i| at[i as usize]), x);
            if inside {
                edges.extend([[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
            }
            !inside
        });
        edges.sort_unstable();
        let rim = edges.iter().filter(|[a, b]| edges.binary_search(&[*b, *a]).is_err());
        triangles.extend(rim.map(|&[a, b]| [a, b, p]));
    }
    triangles.retain(|t| t.iter().all(|&i| i < n));
    triangles
}

/// True when `x` lies inside the circle through a triangle that turns left.
fn in_circle(t: [PlanePoint; 3], x: PlanePoint) -> bool {
    let d = t.map(|p| [i128::from(p[0] - x[0]), i128::from(p[1] - x[1])]);
    let lift = d.map(|[a, b]| a * a + b * b);
    let cross = |i: usize, j: usize| d[i][0] * d[j][1] - d[j][0] * d[i][1];
    lift[0] * cross(1, 2) + lift[1] * cross(2, 0) + lift[2] * cross(0, 1) > 0
}
