import { useEffect, useState } from "preact/hooks";
import type { Block, Line } from "../legal/legal_text";
import { loadLegalText, type LoadedText } from "../legal/load_legal_text";
import { language, t } from "../texts";
import { Loading } from "./loading";
import { legalPages, type LegalPage } from "./routes";
import { Notice, PageTitle } from "./shell";

/** One of the installation's own pages: the privacy notice, the terms or the contact. */
export function Legal({ page }: { readonly page: LegalPage }) {
  const [text, setText] = useState<LoadedText | null>(null);
  const [round, setRound] = useState(0);
  const [failed, setFailed] = useState(false);
  useEffect(() => {
    let here = true;
    setFailed(false);
    loadLegalText(page, language.value).then(
      (loaded) => here && setText(loaded),
      () => here && setFailed(true),
    );
    return () => void (here = false);
  }, [page, round]);
  return (
    <div class="page page-narrow">
      <PageTitle text={text?.title ?? t.legal.pages[page]} />
      {failed ? (
        <>
          <Notice kind="bad">{t.legal.failed}</Notice>
          <p>
            <button type="button" class="button" onClick={() => setRound(round + 1)}>
              {t.tryAgain}
            </button>
          </p>
        </>
      ) : text ? (
        <>
          {text.isTemplate ? <Notice kind="bad">{t.legal.template}</Notice> : null}
          <article class="legal" lang={text.language}>
            {text.blocks.map((block, i) => (
              <LegalBlock key={i} block={block} />
            ))}
          </article>
        </>
      ) : (
        <Loading />
      )}
    </div>
  );
}

function LegalBlock({ block }: { readonly block: Block }) {
  if (block.kind === "heading") return <h2>{block.text}</h2>;
  if (block.kind === "list")
    return (
      <ul>
        {block.items.map((line, i) => (
          <li key={i}>
            <Spans line={line} />
          </li>
        ))}
      </ul>
    );
  return (
    <p>
      {block.lines.map((line, i) => (
        <span key={i} class="legal-line">
          <Spans line={line} />
        </span>
      ))}
    </p>
  );
}

function Spans({ line }: { readonly line: Line }) {
  return (
    <>
      {line.map((span, i) =>
        span.kind === "link" ? (
          <a key={i} href={span.href}>
            {span.text}
          </a>
        ) : span.kind === "gap" ? (
          <mark key={i}>{span.text}</mark>
        ) : (
          span.text
        ),
      )}
    </>
  );
}

/** Tells administrators which of these pages the installation has not filled in. */
export function LegalReminder() {
  const [missing, setMissing] = useState<readonly LegalPage[]>([]);
  useEffect(() => {
    let here = true;
    const isMissing = (page: LegalPage) =>
      loadLegalText(page, language.value).then(
        (text) => text.isTemplate,
        () => false,
      );
    void Promise.all(legalPages.map(isMissing)).then(
      (found) => here && setMissing(legalPages.filter((_, i) => found[i])),
    );
    return () => void (here = false);
  }, []);
  if (missing.length === 0) return null;
  return <Notice kind="bad">{t.legal.reminder(missing.map((page) => t.legal.pages[page]).join(", "))}</Notice>;
}
