// Opens reports in a real browser and uses them as a person would:
//   phalanx run uav && phalanx report runs/uav-TSC.mcap
//   npm ci && node report.mjs ../../runs/uav-TSC.html [...]
// Fails on any error in the console, on any request to anything but the file itself, and on a control without effect.
// CHROMIUM names the browser (/usr/bin/chromium), PICTURES a folder for screenshots (none are taken without it).

import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const files = process.argv.slice(2);
assert.ok(files.length, "usage: node report.mjs REPORT.html [...]");

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

/** What a canvas shows, and whether that is anything. */
const look = (page, selector) =>
  page.locator(selector).first().evaluate((canvas) => {
    const blank = document.createElement("canvas");
    Object.assign(blank, { width: canvas.width, height: canvas.height });
    return { pixels: canvas.toDataURL(), empty: canvas.toDataURL() === blank.toDataURL() };
  });

const clock = async (page) => Number.parseFloat(await page.locator("#clock").innerText());

const checkReport = async (file) => {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: "light" });
  const address = pathToFileURL(resolve(file)).href;
  const wrong = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && wrong.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(`error: ${error.stack}`));
  page.on("request", (request) => {
    if (request.url() !== address && !request.url().startsWith("data:")) wrong.push(`request: ${request.url()}`);
  });
  const before = performance.now();
  await page.goto(address);
  await page.waitForFunction(() => document.querySelectorAll(".plot canvas").length > 0);
  const opened = performance.now() - before;

  const picture = async (name) => {
    if (!process.env.PICTURES) return;
    await mkdir(process.env.PICTURES, { recursive: true });
    await page.screenshot({ path: join(process.env.PICTURES, `${basename(file, ".html")}-${name}.png`) });
  };
  const changes = async (selector, what, act) => {
    const first = await look(page, selector);
    await act();
    await page.waitForTimeout(120);
    assert.ok((await look(page, selector)).pixels !== first.pixels, `${what} changes nothing in ${selector}`);
  };

  const plots = await page.locator(".plot").count();
  assert.ok(plots >= 3, `only ${plots} plots`);
  for (let k = 0; k < plots; k += 1) {
    await page.locator(`.plot:nth-of-type(${k + 1})`).scrollIntoViewIfNeeded();
    await page.waitForTimeout(100);
    const { empty } = await look(page, `.plot:nth-of-type(${k + 1}) canvas`);
    assert.ok(!empty, `plot ${k + 1} is empty`);
  }
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(100);
  await picture("light");

  // Time: play moves it, pause stops it, a click into a plot sets it.
  const end = await clock(page);
  await page.locator("#scrub").evaluate((scrub) => {
    scrub.value = 0;
    scrub.dispatchEvent(new Event("input"));
  });
  assert.equal(await clock(page), 0);
  await changes(".scene canvas", "playing", async () => {
    await page.locator("#play").click();
    await page.waitForFunction(() => Number.parseFloat(document.getElementById("clock").textContent) > 0);
  });
  await page.locator("#play").click();
  const paused = await clock(page);
  assert.ok(paused > 0 && paused <= end, `the time stands at ${paused}`);
  await page.waitForTimeout(200);
  assert.equal(await clock(page), paused, "pause does not stop the time");
  const canvas = page.locator(".plot .frame canvas").nth(1);
  const box = await canvas.boundingBox();
  await canvas.click({ position: { x: box.width / 2, y: box.height / 2 } });
  const middle = await clock(page);
  assert.ok(Math.abs(middle - end / 2) < end / 10, `a click into the middle of a plot sets the time ${middle}`);
  await picture("middle");

  // Everything that can be chosen has an effect.
  await changes(".plot canvas", "singling out an agent", async () => {
    await page.locator("#agents .chip").first().click();
    await page.mouse.move(2, 2);
  });
  await picture("solo");
  await page.locator("#agents .chip").first().click();
  await page.mouse.move(2, 2);
  await changes(".plot canvas", "the scale", () => page.locator(".plot button.quiet").first().click());
  await page.locator(".plot button.quiet").first().click();
  const peaks = page.locator(".plot button:visible", { hasText: "show peaks" }).first();
  if (await peaks.count()) {
    const plot = await peaks.evaluate((button) => button.closest(".plot").id);
    await peaks.scrollIntoViewIfNeeded();
    await page.waitForTimeout(120);
    await changes(`#${plot} canvas`, "showing peaks", () => page.locator(`#${plot} button`, { hasText: "show peaks" }).click());
    await page.locator(`#${plot} button`, { hasText: "cut peaks" }).click();
    await page.evaluate(() => window.scrollTo(0, 0));
  }
  const crossing = await page.evaluate(() => [...document.querySelectorAll(".wide table")].filter((table) => {
    const [own, around] = [table, table.closest(".card")].map((node) => node.getBoundingClientRect());
    const next = table.nextElementSibling?.getBoundingClientRect();
    return own.right > around.right + 1 || (next && next.top < own.bottom && next.left < own.right - 1);
  }).length);
  assert.equal(crossing, 0, "tables run into each other or out of their card");
  await changes(".plot canvas", "zooming", async () => {
    await page.mouse.move(box.x + box.width * 0.3, box.y + 50);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.6, box.y + 60, { steps: 4 });
    await page.mouse.up();
  });
  await changes(".plot canvas", "double-click", () => canvas.dblclick({ position: { x: 200, y: 60 } }));
  await changes(".scene canvas", "dragging", async () => {
    const scene = await page.locator(".scene canvas").first().boundingBox();
    await page.mouse.move(scene.x + 100, scene.y + 100);
    await page.mouse.down();
    await page.mouse.move(scene.x + 160, scene.y + 120, { steps: 4 });
    await page.mouse.up();
    await page.mouse.wheel(0, -200);
  });
  await changes(".scene canvas", "reset", () => page.locator("#home").click());
  await changes(".scene canvas", "following", () => page.locator("#follow").selectOption({ index: 1 }));
  await page.locator("#follow").selectOption({ index: 0 });
  for (const select of await page.locator(".plot select").all())
    for (let option = await select.locator("option").count(); option > 0; option -= 1) await select.selectOption({ index: option - 1 });
  for (const tab of await page.locator(".tabs button").all()) await tab.click();
  for (const tab of await page.locator(".tabs button:first-child").all()) await tab.click();

  // Dark, and on paper.
  await changes(".plot canvas", "the dark theme", () => page.locator("#theme").click());
  await page.evaluate(() => window.scrollTo(0, 0));
  await picture("dark");
  await page.locator("#theme").click();
  await page.emulateMedia({ media: "print" });
  await page.evaluate(() => window.dispatchEvent(new Event("beforeprint")));
  assert.ok(!(await look(page, ".plot .frame canvas")).empty, "a printed plot is empty");
  assert.equal(await page.locator(".plot .frame canvas:visible").count(), plots, "something covers the printed plots");
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await page.emulateMedia({ media: null });
  if (process.env.PICTURES) await page.pdf({ path: join(process.env.PICTURES, `${basename(file, ".html")}.pdf`), format: "A4" });
  await page.evaluate(() => document.getElementById("metrics").scrollIntoView());
  await picture("metrics");

  // On a telephone nothing is wider than the screen, but for what scrolls by itself.
  await page.setViewportSize({ width: 400, height: 800 });
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(150);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth + 1), "the page is wider than a small screen");
  const heading = await page.locator("h1").boundingBox();
  assert.ok(heading.width > 250, `the heading is squeezed to ${heading.width} pixels`);
  await picture("narrow");

  assert.deepEqual(wrong, []);
  await page.close();
  console.log(`${file}: ${plots} plots, drawn after ${opened.toFixed(0)} ms; all controls work, no error, no request`);
};

try {
  for (const file of files) await checkReport(file);
} finally {
  await browser.close();
}
