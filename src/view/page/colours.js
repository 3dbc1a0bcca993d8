// Scales of colour. Both differ in lightness all along, so that they read without hue, too.

const SEQUENTIAL = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];
const DIVERGING = {
  light: ["#08519c", "#4292c6", "#9ecae1", "#f7f7f7", "#fdae6b", "#e6550d", "#8c2d04"],
  dark: ["#9ecae1", "#4292c6", "#1f5a8c", "#1c1f24", "#9a4a12", "#f07f24", "#fdd0a2"],
};

const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;

function channelsOf(hex) {
  return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
}

// The colour at x of 0 to 1 between stops, as bytes.
function between(stops, x) {
  const place = clamp(Number.isFinite(x) ? x : 0, 0, 1) * (stops.length - 1);
  const low = Math.min(Math.floor(place), stops.length - 2);
  const [a, b] = [channelsOf(stops[low]), channelsOf(stops[low + 1])];
  return a.map((value, i) => Math.round(value + (b[i] - value) * (place - low)));
}

const sequential = (x) => between(SEQUENTIAL, x);
const diverging = (x) => between(DIVERGING[isDark() ? "dark" : "light"], x);

// An image of `width` by `height` colours as a data URL, its first row at the bottom.
function imageOf(width, height, colour) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  const image = context.createImageData(width, height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      image.data.set([...colour(x, height - 1 - y), 255], 4 * (y * width + x));
    }
  }
  context.putImageData(image, 0, 0);
  return canvas.toDataURL();
}

// The page's own colours, to draw what cannot inherit them.
function groundColour() {
  return channelsOf(getComputedStyle(document.documentElement).getPropertyValue("--panel").trim()).map((c) => c / 255);
}
