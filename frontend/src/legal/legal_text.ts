/**
 * The format of the installation's own texts (public/legal): paragraphs separated by blank lines,
 * headings that begin with # or ##, lists whose lines begin with -, and placeholders between [[ and
 * ]]. Addresses become links.
 */

export type Span =
  | { readonly kind: "text"; readonly text: string }
  | { readonly kind: "link"; readonly text: string; readonly href: string }
  | { readonly kind: "gap"; readonly text: string };

export type Line = readonly Span[];

export type Block =
  | { readonly kind: "heading"; readonly text: string }
  | { readonly kind: "paragraph"; readonly lines: readonly Line[] }
  | { readonly kind: "list"; readonly items: readonly Line[] };

export interface LegalText {
  /** The first heading, or null if the text begins without one. */
  readonly title: string | null;
  readonly blocks: readonly Block[];
  /** Whether the text still has a placeholder that the operator has to fill in. */
  readonly isTemplate: boolean;
}

const special =
  /\[\[(?<gap>[^\]]+)\]\]|(?<url>https:\/\/[^\s<>"]*[^\s<>".,;:!?)])|(?<email>[\w.+-]+@[\w-]+(?:\.[\w-]+)+)/g;

function spansOf(line: string): Line {
  const spans: Span[] = [];
  let at = 0;
  for (const found of line.matchAll(special)) {
    if (found.index > at) spans.push({ kind: "text", text: line.slice(at, found.index) });
    const { gap, url, email } = found.groups ?? {};
    if (gap !== undefined) spans.push({ kind: "gap", text: gap });
    else if (url !== undefined) spans.push({ kind: "link", text: url, href: url });
    else if (email !== undefined) spans.push({ kind: "link", text: email, href: `mailto:${email}` });
    at = found.index + found[0].length;
  }
  if (at < line.length) spans.push({ kind: "text", text: line.slice(at) });
  return spans;
}

const heading = /^#{1,6} +(.*)$/;
const item = /^- +(.*)$/;

function blocksOf(lines: readonly string[]): Block[] {
  const blocks: Block[] = [];
  let paragraph: Line[] = [];
  let list: Line[] = [];
  const end = () => {
    if (paragraph.length > 0) blocks.push({ kind: "paragraph", lines: paragraph });
    if (list.length > 0) blocks.push({ kind: "list", items: list });
    paragraph = [];
    list = [];
  };
  for (const line of lines) {
    const title = heading.exec(line)?.[1];
    const entry = item.exec(line)?.[1];
    if (title !== undefined || line === "" || (entry !== undefined) !== list.length > 0) end();
    if (title !== undefined) blocks.push({ kind: "heading", text: title });
    else if (entry !== undefined) list.push(spansOf(entry));
    else if (line !== "") paragraph.push(spansOf(line));
  }
  end();
  return blocks;
}

export function readLegalText(text: string): LegalText {
  const blocks = blocksOf(text.split("\n").map((line) => line.trim()));
  const [first, ...rest] = blocks;
  const titled = first?.kind === "heading";
  return {
    title: titled ? first.text : null,
    blocks: titled ? rest : blocks,
    isTemplate: /\[\[[^\]]+\]\]/.test(text),
  };
}
