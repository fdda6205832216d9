import { readdirSync, readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { legalPages } from "../views/routes";
import { languages } from "../texts/choose";
import { readLegalText } from "./legal_text";
import { loadLegalText } from "./load_legal_text";

const folder = new URL("../../public/legal/", import.meta.url);

describe("a text of the installation", () => {
  it("has a title, headings, paragraphs of lines, and lists", () => {
    const text = readLegalText(
      "# Contact\n\nExample Ltd\n1 Main Street\n\n## Help\nWe help with:\n- scans\n- accounts\n",
    );
    expect(text.title).toBe("Contact");
    expect(text.blocks.map((block) => block.kind)).toEqual(["paragraph", "heading", "paragraph", "list"]);
    const [address, , , list] = text.blocks;
    expect(address?.kind === "paragraph" && address.lines.length).toBe(2);
    expect(list?.kind === "list" && list.items.length).toBe(2);
    expect(text.isTemplate).toBe(false);
  });
  it("links only addresses of websites and emails, without the full stop behind them", () => {
    const [block] = readLegalText(
      "See https://example.org/a?b=c. Write to help@example.org, or javascript:alert(1).",
    ).blocks;
    const spans = block?.kind === "paragraph" ? (block.lines[0] ?? []) : [];
    expect(spans.filter((span) => span.kind === "link")).toEqual([
      { kind: "link", text: "https://example.org/a?b=c", href: "https://example.org/a?b=c" },
      { kind: "link", text: "help@example.org", href: "mailto:help@example.org" },
    ]);
  });
  it("is a template while a place is not filled in", () => {
    const text = readLegalText("Name: [[name of the operator]]");
    expect(text.isTemplate).toBe(true);
    expect(text.blocks).toEqual([
      {
        kind: "paragraph",
        lines: [
          [
            { kind: "text", text: "Name: " },
            { kind: "gap", text: "name of the operator" },
          ],
        ],
      },
    ]);
  });
});

describe("the templates", () => {
  it("exist for every page in every language, and each has places to fill in", () => {
    const wanted = legalPages.flatMap((page) => Object.keys(languages).map((language) => `${page}.${language}.txt`));
    expect(readdirSync(folder).sort()).toEqual(wanted.sort());
    for (const name of wanted) {
      const text = readLegalText(readFileSync(new URL(name, folder), "utf8"));
      expect(text.title, name).not.toBeNull();
      expect(text.isTemplate, name).toBe(true);
    }
  });
});

describe("loading", () => {
  const server = (texts: Readonly<Record<string, string>>) => (url: string) =>
    Promise.resolve(url in texts ? new Response(texts[url]) : new Response("", { status: 404 }));
  it("prefers a text in another language to a template", async () => {
    const get = server({ "/legal/terms.en.txt": "[[fill in]]", "/legal/terms.de.txt": "# Bedingungen" });
    expect(await loadLegalText("terms", "en", get)).toMatchObject({ language: "de", isTemplate: false });
    expect(await loadLegalText("terms", "de", get)).toMatchObject({ language: "de", title: "Bedingungen" });
  });
  it("shows the template if nothing is filled in, and fails if there is no text at all", async () => {
    const get = server({ "/legal/terms.en.txt": "[[fill in]]" });
    expect(await loadLegalText("terms", "en", get)).toMatchObject({ language: "en", isTemplate: true });
    await expect(loadLegalText("privacy", "en", get)).rejects.toThrow("404");
  });
});
