// Opens the book in a real browser, from the disk:
//   cargo run --manifest-path tests/book/Cargo.toml
//   npm ci && node book.mjs ../../target/book
// Fails on any error in the console, on any request to anything but the disk, on a page that is wider than the window, and if the
// search does not find what it should.
// CHROMIUM names the browser (/usr/bin/chromium), PICTURES a folder for screenshots (none are taken without it).

import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [folder] = process.argv.slice(2);
assert.ok(folder, "usage: node book.mjs FOLDER");
const address = (page) => pathToFileURL(join(resolve(folder), page)).href;
const PAGES = ["index", "gallery", "glossary", "coming-from", "speed", "measurements", "api", "api/c", "api/python", "running", "commands", "thesis-results"];
const WIDTHS = [1400, 390];

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});
const wrong = [];

const open = async (width) => {
  const page = await browser.newPage({ viewport: { width, height: 900 }, colorScheme: "light" });
  page.setDefaultTimeout(120_000);
  page.on("console", (message) => message.type() === "error" && wrong.push(`${page.url()}: ${message.text()}`));
  page.on("pageerror", (error) => wrong.push(`${page.url()}: ${error.stack}`));
  page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || wrong.push(`request: ${request.url()}`));
  return page;
};
const picture = async (page, name) => {
  if (!process.env.PICTURES) return;
  await mkdir(process.env.PICTURES, { recursive: true });
  await page.screenshot({ path: join(process.env.PICTURES, `${name}.png`) });
};

/** Types a word into the search and returns the titles of what is found. */
const search = async (page, word) => {
  await page.locator("#mdbook-search-toggle").click();
  // All letters but the last at once: the page searches after each key, which takes long on a busy machine.
  await page.locator("#mdbook-searchbar").fill(word.slice(0, -1));
  await page.locator("#mdbook-searchbar").press(word.slice(-1));
  await page.waitForFunction(() => document.querySelectorAll("#mdbook-searchresults li").length > 0, null);
  return page.locator("#mdbook-searchresults li a").allInnerTexts();
};

try {
  for (const width of WIDTHS) {
    const page = await open(width);
    for (const name of PAGES) {
      await page.goto(address(`${name}.html`));
      const excess = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      if (excess > 0) wrong.push(`${name}.html is ${excess} pixels wider than a window of ${width}`);
      await picture(page, `${name.replace("/", "-")}-${width}`);
    }
    for (const [word, title] of [["anti-windup", "Glossary"], ["phalanx_neighbours", "phalanx_neighbours"], ["quadcopters", "uav"]]) {
      await page.goto(address("index.html"));
      const titles = await search(page, word);
      if (word === "anti-windup") await picture(page, `search-${width}`);
      assert.ok(titles.some((one) => one.includes(title)), `a search for ${word} does not find ${title}, only ${titles}`);
    }
    await page.locator("#mdbook-searchresults li a").first().click();
    await page.waitForFunction(() => document.querySelectorAll("mark").length > 0);
    await page.close();
  }
  assert.deepEqual(wrong, []);
  console.log(`${PAGES.length} pages at ${WIDTHS.join(" and ")} pixels, and the search`);
} finally {
  await browser.close();
}
