// Thin a long curve to what can be seen of it.

/**
 * Return a curve of points {x, y} that looks the same: of every stretch of neighbours its first point, its lowest and
 * its highest. A curve that has few points for its width is returned as it is.
 */
export function thin(points, columns) {
  const stretch = Math.ceil(points.length / columns);
  if (stretch < 4) return points;
  const kept = [];
  for (let from = 0; from < points.length; from += stretch) {
    const to = Math.min(from + stretch, points.length);
    let low = from, high = from;
    for (let k = from; k < to; k += 1) {
      if (points[k].y < points[low].y) low = k;
      if (points[k].y > points[high].y) high = k;
    }
    for (const k of [...new Set([from, low, high])].sort((a, b) => a - b)) kept.push(points[k]);
  }
  kept.push(points.at(-1));
  return kept;
}
