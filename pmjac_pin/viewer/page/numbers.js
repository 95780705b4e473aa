// Numbers as text that keeps its width while it changes.

export const minus = (text) => text.replace("-", "−");

export function fixed(value, digits) {
  if (value === null || !Number.isFinite(value)) return "—";
  const size = Math.abs(value);
  if (size >= 1e5) return minus(value.toExponential(2));
  const surplus = size >= 100 ? Math.floor(Math.log10(size)) - 1 : 0;  // as wide as the others
  const text = value.toFixed(Math.max(1, digits - surplus));
  return minus(Number(text) === 0 ? (0).toFixed(digits) : text);
}

export function relative(value) {  // numbers that may fall towards zero
  if (value === null) return "—";
  return minus(value >= 1e-3 || value === 0 ? value.toFixed(4) : value.toExponential(2));
}

// Four significant digits of the largest number at home, and as many decimals for all.
export function decimalsFor(values) {
  const largest = Math.max(0, ...values.map(Math.abs));
  if (largest === 0) return 4;
  return Math.min(9, Math.max(2, 3 - Math.floor(Math.log10(largest)) + (largest < 1 ? 0 : 1)));
}

export const decimalsOfRange = (range) => Math.min(9, Math.max(4, 4 - Math.floor(Math.log10(range || 1))));

export function niceStep(range) {  // of an arrow key: about a two-hundredth
  const raw = range / 200 || 1e-3;
  const power = 10 ** Math.floor(Math.log10(raw));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * raw);
}
