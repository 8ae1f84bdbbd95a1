// Opens reports in a real browser and uses them as a person would:
//   phalanx run uav && phalanx report runs/uav-TSC.mcap
//   npm ci && node report.mjs ../../runs/uav-TSC.html [...]
// Fails on any error in the console, on any request to anything but the file itself, on a control or key without effect, and on
// a table that does not fit a telephone.
// CHROMIUM names the browser (/usr/bin/chromium), PICTURES a folder for screenshots (none are taken without it).

import assert from "node:assert/strict";
import { mkdir, readFile } from "node:fs/promises";
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

/** Keys mean the playback, wherever the last click left the focus, and never scroll the page. */
const checkKeys = async (page, end) => {
  const scrolled = () => page.evaluate(() => window.scrollY);
  const isPlaying = () => page.locator("#play").evaluate((button) => button.classList.contains("playing"));
  await page.evaluate(() => window.scrollTo(0, 0));
  const slider = await page.locator("#scrub").boundingBox();
  const uses = {
    "scrubbing the slider": () => page.mouse.click(slider.x + slider.width / 4, slider.y + slider.height / 2),
    "choosing a speed": async () => {
      await page.locator("#speed").focus();
      await page.locator("#speed").selectOption({ index: 1 });
    },
    "choosing an agent": async () => {
      await page.locator("#agents .chip").first().click();
      await page.locator("#agents .chip").first().click();
    },
    "showing links": async () => {
      await page.locator("#links").click();
      await page.locator("#links").click();
    },
  };
  for (const [what, use] of Object.entries(uses)) {
    await use();
    await page.keyboard.press("Home");
    assert.equal(await clock(page), 0, `Home after ${what}`);
    await page.keyboard.press("Space");
    assert.ok(await isPlaying(), `Space after ${what} does not play`);
    await page.waitForFunction(() => Number.parseFloat(document.getElementById("clock").textContent) > 0);
    await page.keyboard.press("Space");
    assert.ok(!(await isPlaying()), `Space after ${what} does not pause`);
    await page.keyboard.press("End");
    assert.ok(Math.abs((await clock(page)) - end) < 1e-9, `End after ${what}`);
    assert.equal(await scrolled(), 0, `a key after ${what} scrolls the page`);
  }
  const scale = page.locator(".plot button.quiet:visible").first();
  const before = await scale.innerText();
  await page.mouse.move(2, 2);
  // If any plot is logarithmic, all become linear.
  await page.keyboard.press("l");
  if (before === "linear" && (await scale.innerText()) === before) await page.keyboard.press("l");
  assert.notEqual(await scale.innerText(), before, "the key L does not change the scale");
  await page.keyboard.press("l");
  const number = await page.locator("#agents .chip").first().innerText();
  await page.keyboard.press(number.trim());
  assert.equal(await page.locator("#agents .chip").first().getAttribute("aria-pressed"), "true", "a digit singles out no agent");
  await page.keyboard.press("0");
  assert.equal(await page.locator("#agents .chip[aria-pressed=true]").count(), 0, "0 does not show all agents");
  await page.keyboard.press("?");
  assert.match(await page.locator("#help").innerText(), /Space/, "? shows no help");
  await page.keyboard.press("?");
  assert.ok(!(await page.locator("#help").isVisible()), "? does not hide the help");
};

/** Each plot can be saved, as it is shown. */
const checkSaving = async (page) => {
  for (const [ending, isRight] of [
    ["svg", (bytes) => /^<svg [^>]*xmlns=/.test(bytes) && bytes.includes("<path") && !bytes.includes("NaN")],
    ["png", (bytes) => bytes.subarray(1, 4).toString() === "PNG"],
    ["csv", (bytes) => /^(run,)?t \[s\],/.test(bytes) && String(bytes).split("\n").length > 100],
  ]) {
    await page.locator(".plot .menu summary").first().click();
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator(".plot .menu button", { hasText: ending.toUpperCase() }).first().click()]);
    assert.ok(download.suggestedFilename().endsWith(`.${ending}`), download.suggestedFilename());
    const bytes = await readFile(await download.path());
    assert.ok(isRight(bytes), `a saved plot is no ${ending}: ${bytes.subarray(0, 200)}`);
    if (process.env.PICTURES) await download.saveAs(join(process.env.PICTURES, download.suggestedFilename()));
  }
};

/** Everything that was violated stands in the heading, in colour, and leads to its time. */
const checkWarnings = async (page) => {
  const violated = page.locator("#assertions td.warn, #assertions td.bad");
  const said = page.locator("#alarms p");
  assert.equal(await said.count(), await violated.count(), "the heading does not name what was violated");
  if (!(await said.count())) return;
  const colour = (locator) => locator.first().evaluate((node) => getComputedStyle(node).color);
  assert.notEqual(await colour(said), await colour(page.locator("h1")), "a violation has the colour of text");
  const link = said.first().locator("a").first();
  const time = Number((await link.getAttribute("href")).split("=")[1]);
  await link.click();
  await page.waitForTimeout(50);
  assert.ok(Math.abs((await clock(page)) - time) < 0.01, "a violation does not lead to its time");
};

/** A link to a time opens there, and the theme stays. */
const checkAddress = async (page, address, end) => {
  await page.keyboard.press("t");
  const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
  assert.equal(await theme(), "dark");
  await page.goto("about:blank");
  await page.goto(`${address}#t=${end / 4}`);
  await page.waitForFunction(() => document.querySelectorAll(".plot canvas").length > 0);
  assert.ok(Math.abs((await clock(page)) - end / 4) < 0.01, "#t= does not set the time");
  assert.equal(await theme(), "dark", "the theme is forgotten");
  await page.keyboard.press("t");
  await page.keyboard.press("Home");
  await page.waitForFunction(() => location.hash === "#t=0");
};

/** The value below the pointer is shown by all plots. */
const checkHover = async (page, box) => {
  const other = page.locator(".plot .frame canvas + canvas").nth(1);
  const before = await other.evaluate((canvas) => canvas.toDataURL());
  await page.mouse.move(box.x + box.width * 0.4, box.y + 80);
  await page.waitForTimeout(120);
  assert.notEqual(await other.evaluate((canvas) => canvas.toDataURL()), before, "a plot does not follow the pointer in another one");
  await page.mouse.move(2, 2);
};

const checkReport = async (file) => {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: "light" });
  const address = pathToFileURL(resolve(file)).href;
  const wrong = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && wrong.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(`error: ${error.stack}`));
  page.on("request", (request) => {
    if (request.url().split("#")[0] !== address && !/^(data|blob):/.test(request.url())) wrong.push(`request: ${request.url()}`);
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
  await checkKeys(page, end);
  await checkSaving(page);
  await checkWarnings(page);

  // Everything that can be chosen has an effect.
  await page.evaluate(() => window.scrollTo(0, 0));
  await checkHover(page, box);
  await changes(".plot canvas", "singling out an agent", async () => {
    await page.locator("#agents .chip").first().click();
    await page.mouse.move(2, 2);
  });
  await picture("solo");
  await page.locator("#agents .chip").first().click();
  await page.mouse.move(2, 2);
  await changes(".plot canvas", "the scale", () => page.locator(".plot button.quiet").first().click());
  await page.locator(".plot button.quiet").first().click();
  // A plot is drawn when it comes into view, and whether it cuts peaks is known only then.
  const cutting = await page.locator(".plot button:visible", { hasText: "show peaks" }).evaluateAll((all) => all.map((one) => one.closest(".plot").id));
  for (const plot of cutting) {
    await page.locator(`#${plot}`).scrollIntoViewIfNeeded();
    await page.waitForTimeout(120);
    const button = page.locator(`#${plot} button`, { hasText: /show peaks|cut peaks/ });
    if (!(await button.isVisible())) continue;
    await changes(`#${plot} canvas`, "showing peaks", () => button.click());
    await button.click();
    break;
  }
  await page.evaluate(() => window.scrollTo(0, 0));
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

  await page.evaluate(() => window.scrollTo(0, 0));
  await checkAddress(page, address, end);

  // On a telephone nothing is wider than the screen, and nothing of a table is out of sight.
  await page.setViewportSize({ width: 390, height: 844 });
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(150);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth + 1), "the page is wider than a small screen");
  const outside = await page.evaluate(() => [...document.querySelectorAll(".wide td")].filter((cell) => {
    const { left, right, width } = cell.getBoundingClientRect();
    return width > 0 && (left < 0 || right > window.innerWidth || cell.scrollWidth > cell.clientWidth + 1);
  }).map((cell) => cell.textContent));
  assert.deepEqual(outside, [], "cells of tables are out of sight on a small screen");
  const scenes = await page.locator(".scene").evaluateAll((cards) => cards.map((card) => card.getBoundingClientRect().width));
  assert.ok(scenes.every((width) => width > 300), `scenes are squeezed to ${scenes} pixels`);
  const heading = await page.locator("h1").boundingBox();
  assert.ok(heading.width > 250, `the heading is squeezed to ${heading.width} pixels`);
  await picture("narrow");
  await page.evaluate(() => document.getElementById("metrics").scrollIntoView());
  await picture("narrow-metrics");

  assert.deepEqual(wrong, []);
  await page.close();
  console.log(`${file}: ${plots} plots, drawn after ${opened.toFixed(0)} ms; all controls work, no error, no request`);
};

try {
  for (const file of files) await checkReport(file);
} finally {
  await browser.close();
}
