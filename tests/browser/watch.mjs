// Looks at a run while it goes on, in a real browser:
//   phalanx watch --web --no-open & phalanx run uav --realtime 4 --duration 40
//   npm ci && node watch.mjs http://127.0.0.1:8467/
// Fails on any error in the console, on any request to another address, and if the page does not grow.
// CHROMIUM names the browser (/usr/bin/chromium), PICTURES a folder for screenshots (none are taken without it).

import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { chromium } from "playwright-core";

const [address] = process.argv.slice(2);
assert.ok(address, "usage: node watch.mjs ADDRESS");

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

const pixels = (page, selector) => page.locator(selector).first().evaluate((canvas) => canvas.toDataURL());
const clock = async (page) => Number.parseFloat(await page.locator("#clock").innerText());
const until = (page, what) => page.waitForFunction(what, null, { timeout: 60_000 });

try {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: "light" });
  const wrong = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && wrong.push(`console: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(`error: ${error.stack}`));
  page.on("request", (request) => {
    if (!request.url().startsWith(address) && !request.url().startsWith("data:")) wrong.push(`request: ${request.url()}`);
  });
  const picture = async (name) => {
    if (!process.env.PICTURES) return;
    await mkdir(process.env.PICTURES, { recursive: true });
    await page.screenshot({ path: join(process.env.PICTURES, `watch-${name}.png`) });
  };
  await page.goto(address);
  await until(page, () => document.querySelectorAll(".plot canvas").length > 0);
  assert.ok(!(await page.locator("#facts").innerText()).includes("curves from"), "the curves do not begin with the run");

  // It grows by itself: the clock, the scene and a plot.
  const before = { time: await clock(page), scene: await pixels(page, ".scene canvas"), plot: await pixels(page, ".plot canvas") };
  await page.waitForTimeout(1000);
  assert.ok((await clock(page)) > before.time, "the time does not move");
  assert.notEqual(await pixels(page, ".scene canvas"), before.scene, "nothing moves in the scene");
  assert.notEqual(await pixels(page, ".plot canvas"), before.plot, "the plot does not grow");
  await until(page, () => document.querySelector(".facts span")?.textContent.includes("steps/s"));
  await page.waitForTimeout(1500);
  await picture("live");

  // Back in time, while the page grows on; and forward to the run again.
  await page.locator("#scrub").evaluate((scrub) => {
    scrub.value = 0;
    scrub.dispatchEvent(new Event("input"));
  });
  await page.waitForTimeout(300);
  assert.equal(await clock(page), 0, "the time does not stay where it was put");
  assert.equal(await page.locator(".live").getAttribute("aria-pressed"), "false");
  const end = Number(await page.locator("#scrub").getAttribute("max"));
  await page.locator("#play").click();
  await page.waitForTimeout(500);
  assert.ok((await clock(page)) > 0, "playing does not move the time");
  assert.ok(Number(await page.locator("#scrub").getAttribute("max")) > end, "the page stopped growing");
  await page.locator(".live").click();
  await page.waitForTimeout(300);
  assert.ok((await clock(page)) > end, "the page does not return to the run");
  await page.keyboard.press("Home");
  assert.equal(await clock(page), 0, "Home does not go to the start");
  await page.keyboard.press("End");
  await page.waitForTimeout(300);
  assert.equal(await page.locator(".live").getAttribute("aria-pressed"), "true", "End does not follow the run again");

  // The end is said, and everything stays.
  await until(page, () => document.documentElement.dataset.over !== undefined);
  assert.match(await page.locator(".facts span").innerText(), /is over: all \d+ steps are done/);
  const [last, whole] = (await page.locator("#clock").innerText()).match(/[\d.]+/g).map(Number);
  assert.equal(last, whole, "the last step is missing");
  await page.locator("#scrub").evaluate((scrub) => {
    scrub.value = 0;
    scrub.dispatchEvent(new Event("input"));
  });
  assert.equal(await clock(page), 0);
  await page.locator("#theme").click();
  await page.waitForTimeout(300);
  await picture("over");
  assert.deepEqual(wrong, []);
  console.log(`${address}: grows to ${last} s, goes back and returns, says the end; no error, no other request`);
} finally {
  await browser.close();
}
