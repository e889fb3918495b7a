/// The unit quaternion, scalar part first and never negative, of a rotation matrix r by rows: the column of 4 q qᵀ with the
/// largest diagonal entry, refined by one multiplication.
fn quaternion(r: &[f64; 9]) -> [f64; 4] {
    let (x, y, z) = (r[7] - r[5], r[2] - r[6], r[3] - r[1]);
    let (xy, xz, yz) = (r[1] + r[3], r[2] + r[6], r[5] + r[7]);
    let m = [
        [1.0 + r[0] + r[4] + r[8], x, y, z],
        [x, 1.0 + r[0] - r[4] - r[8], xy, xz],
        [y, xy, 1.0 + r[4] - r[0] - r[8], yz],
        [z, xz, yz, 1.0 + r[8] - r[0] - r[4]],
    ];
    let mut k = 0;
    for i in 1..4 {
        if m[i][i] > m[k][k] {
            k = i;
        }
    }
    let q = m.map(|row| row[0] * m[k][0] + row[1] * m[k][1] + row[2] * m[k][2] + row[3] * m[k][3]);
    let square: f64 = q.iter().map(|part| part * part).sum();
    let factor = (if q[0] < 0.0 { -1.0 } else { 1.0 }) / square.sqrt();
    q.map(|part| part * factor)
}
