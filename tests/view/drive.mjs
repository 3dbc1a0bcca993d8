// Drives a page of `furnace view` in headless Chromium and prints what it saw as JSON; tests/view.rs judges it.
//
// Its one argument is JSON: `library` (the directory of playwright-core), `chromium`, `page` (a file), `reads` (choices for
// window.furnace.read), `shots` (a directory for pictures, or null).

import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const asked = JSON.parse(process.argv[2]);
const { chromium } = createRequire(import.meta.url)(asked.library);
const browser = await chromium.launch({
  executablePath: asked.chromium,
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const address = pathToFileURL(asked.page).href;
const seen = { complaints: [], requests: [], reads: [], keyboard: null, widths: {} };

async function open(options) {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  page.on("console", (message) => message.type() === "error" && seen.complaints.push(message.text()));
  page.on("pageerror", (error) => seen.complaints.push(String(error)));
  page.on("request", (request) => seen.requests.push(request.url()));
  await page.goto(address);
  await page.waitForFunction(() => window.furnace || !document.getElementById("trouble").hidden, null, { timeout: 120000 });
  return [context, page];
}

const text = (page, id) => page.evaluate((id) => document.getElementById(id).textContent, id);

// Every control by Tab alone, and what an arrow key does to it.
async function keyboard(page) {
  const controls = await page.evaluate(() => {
    const all = document.querySelectorAll("main select, main input, main button, main summary");
    const usable = [...all].filter((node) => !node.disabled && node.getClientRects().length);
    return usable.map((node) => ({ id: node.id || node.tagName.toLowerCase(), labels: node.labels ? node.labels.length : 1 }));
  });
  await page.evaluate(() => document.activeElement.blur());
  const reached = [];
  for (let i = 0; i < controls.length + 3; i++) {
    await page.keyboard.press("Tab");
    const id = await page.evaluate(() => document.activeElement.id || document.activeElement.tagName.toLowerCase());
    if (id === "body" || reached.includes(id)) break;
    reached.push(id);
  }
  const moved = {};
  for (const { id } of controls.filter(({ id }) => id !== "summary" && id !== "reset")) {
    const node = page.locator(`[id="${id}"]`);
    const state = () => node.evaluate((node) => (node.type === "checkbox" ? node.checked : node.value));
    await node.focus();
    const before = await state();
    const isCheck = await node.evaluate((node) => node.type === "checkbox");
    for (const key of isCheck ? ["Space"] : ["ArrowRight", "ArrowLeft", "ArrowLeft", "ArrowDown"]) {
      await page.keyboard.press(key);
      if ((await state()) !== before) break;
    }
    moved[id] = (await state()) !== before;
    if (isCheck) await page.keyboard.press("Space");
    await page.keyboard.press("Escape");
  }
  return { controls, reached, moved };
}

try {
  const [context, page] = await open({ viewport: { width: 1280, height: 900 } });
  seen.title = await page.title();
  seen.trouble = await text(page, "trouble");
  seen.materials = await page.evaluate(() => window.furnace?.materials);
  seen.options = await page.evaluate(() => [...document.querySelectorAll("#material option")].map((node) => node.textContent));
  for (const choice of asked.reads) seen.reads.push(await page.evaluate((choice) => window.furnace.read(choice), choice));
  await page.waitForTimeout(600); // the summary waits for quiet
  seen.summary = await text(page, "summary");
  seen.widths.desktop = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  if (asked.keyboard) seen.keyboard = await keyboard(page);
  await context.close();

  const phone = { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true };
  const [small, hand] = await open(phone);
  seen.widths.phone = await hand.evaluate(() => [document.documentElement.scrollWidth, 390]);
  await small.close();
  // the width that text has to flow in at 400 % on a desktop, and that of the smallest phones
  const [least, thumb] = await open({ ...phone, viewport: { width: 320, height: 640 } });
  seen.widths.small = await thumb.evaluate(() => [document.documentElement.scrollWidth, 320]);
  await least.close();

  for (const scheme of asked.shots ? ["light", "dark"] : []) {
    for (const [name, options] of [["desktop", { viewport: { width: 1280, height: 900 } }], ["phone", phone]]) {
      const [context, page] = await open({ ...options, colorScheme: scheme, reducedMotion: "reduce" });
      await page.waitForTimeout(300);
      await page.screenshot({ path: `${asked.shots}/${name}-${scheme}.png`, fullPage: name === "desktop" });
      if (name === "phone") {
        await page.evaluate(() => document.querySelector(".plots").scrollIntoView());
        await page.screenshot({ path: `${asked.shots}/${name}-${scheme}-plots.png` });
      }
      await context.close();
    }
  }
} finally {
  await browser.close();
}
console.log(JSON.stringify(seen));
