import { useEffect, useState } from "preact/hooks";
import { body_parts, type DataSet, type GalleryQuestion, type PresetInfo } from "../api/types";
import { t } from "../texts";
import { Choice } from "./choice";
import { Field } from "./field";
import { Icon } from "./icons";
import { ReportDialog } from "./report_dialog";
import { Link } from "./router";
import { title_of } from "./scan_card";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { PresetPicture, use_thumbnail } from "./thumbnail";

const asked_after_typing_ms = 300;
const all: GalleryQuestion = { q: "", body_part: "", modality: "" };

/** What others made public; without an account the samples. */
export function Gallery() {
  const app = useApp();
  const known = app.me.value !== null;
  const [question, set_question] = useState(all);
  const [found, set_found] = useState<readonly DataSet[] | null>(null);
  const [cursor, set_cursor] = useState<string | null>(null);
  const [fault, set_fault] = useState("");
  const [reported, set_reported] = useState<DataSet | null>(null);

  useEffect(() => {
    const leaving = new AbortController();
    const timer = setTimeout(() => {
      app.api.sharing.gallery(question, null, leaving.signal).then((page) => {
        set_found(page.items);
        set_cursor(page.next_cursor);
        set_fault("");
      }, (thrown: unknown) => {
        if (!leaving.signal.aborted) set_fault(app.explain(thrown));
      });
    }, question === all ? 0 : asked_after_typing_ms);
    return () => {
      clearTimeout(timer);
      leaving.abort();
    };
  }, [app, question, known]);

  const more = () => {
    app.api.sharing.gallery(question, cursor).then((page) => {
      set_found([...(found ?? []), ...page.items]);
      set_cursor(page.next_cursor);
    }, (thrown: unknown) => set_fault(app.explain(thrown)));
  };
  const ask = (part: Partial<GalleryQuestion>) => set_question({ ...question, ...part });
  const text = t.sharing.gallery;
  return (
    <div class="page">
      <div>
        <PageTitle text={text.title} />
        <p class="muted">{known ? text.lead : text.lead_nobody}</p>
      </div>
      {known ? null : <Notice kind="info">{text.sign_up} <Link href="/sign-up">{t.titles.sign_up}</Link></Notice>}
      <form class="gallery-search" role="search" aria-label={text.search} onSubmit={(event) => event.preventDefault()}>
        <Field label={text.words} value={question.q} onInput={(q) => ask({ q })} most={100} />
        <Choice label={t.sharing.details.body_part} value={question.body_part} onChoose={(body_part) => ask({ body_part })}
          options={[["", text.any_part], ...body_parts.map((part): [string, string] => [part, t.sharing.parts[part] ?? part])]} />
        <Choice label={text.kinds.label} value={question.modality} onChoose={(modality) => ask({ modality })}
          options={[["", text.any_kind], ...Object.entries(text.kinds.names)]} />
      </form>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {found === null && !fault ? <p class="muted" role="status">{t.loading}</p> : null}
      {found ? <p class="muted" role="status">{found.length === 0 ? (question === all ? text.nothing_yet : text.nothing) : text.found(found.length, cursor !== null)}</p> : null}
      <ul class="cards" aria-label={text.title}>
        {found?.map((set) => (
          <li key={set.id}><GalleryCard set={set} known={known} onReport={() => set_reported(set)} /></li>
        ))}
      </ul>
      {cursor !== null ? <p><button type="button" class="button" onClick={more}>{text.more}</button></p> : null}
      {reported ? (
        <ReportDialog title={t.sharing.report.title} reasons={t.sharing.report.reasons} onClose={() => set_reported(null)}
          send={(reason, words) => app.api.sharing.report(reported.id, reason, words)} />
      ) : null}
    </div>
  );
}

interface GalleryCardProps {
  readonly set: DataSet;
  readonly known: boolean;
  readonly onReport: () => void;
}

function GalleryCard({ set, known, onReport }: GalleryCardProps) {
  const url = use_thumbnail(set.id, "bone", true);
  const title = title_of(set);
  const text = t.sharing.gallery;
  return (
    <article class="card card-ready" data-id={set.id}>
      <div class={`card-picture ${url ? "" : "card-working"}`}>{url ? <img src={url} alt={t.scans.picture(title)} /> : null}</div>
      <div class="card-text">
        <h2 class="card-title"><Link href={known ? `/view/${set.id}` : `/sample/${set.id}`} class="card-link" label={text.open(title)}>{title}</Link></h2>
        <p class="chips">
          {set.is_sample ? <span class="chip chip-accent">{t.scans.sample}</span> : null}
          {set.volume ? <span class="chip">{set.volume.modality}</span> : null}
          {set.body_part ? <span class="chip">{t.sharing.parts[set.body_part]}</span> : null}
        </p>
        {set.description ? <p class="card-description">{set.description}</p> : null}
        {set.owner_name ? <p class="muted">{text.by(set.owner_name)}</p> : null}
        <CrowdPresets set={set} known={known} />
      </div>
      {known && !set.owned ? (
        <button type="button" class="icon-button card-remove" aria-label={text.report(title)} title={text.report(title)} onClick={onReport}>
          <Icon name="flag" />
        </button>
      ) : null}
    </article>
  );
}

const most_of_crowd = 4;

/** The best of what people saved for a scan; each opens it so. Nothing where there is none. */
function CrowdPresets({ set, known }: { readonly set: DataSet; readonly known: boolean }) {
  const app = useApp();
  const [presets, set_presets] = useState<readonly PresetInfo[]>([]);
  useEffect(() => {
    app.api.presets.list(set.id).then((all) => {
      set_presets(all.filter((one) => one.taken_down === null).slice(0, most_of_crowd));
    }, () => undefined); // the card is whole without them
  }, [app, set.id]);
  if (presets.length === 0) return null;
  return (
    <ul class="crowd" aria-label={t.presets.crowd}>
      {presets.map((preset) => (
        <li key={preset.id}>
          {known ? (
            <Link href={`/view/${set.id}#look=${preset.id}`} class="crowd-link" label={t.presets.apply(preset.name)}><PresetPicture preset={preset} /></Link>
          ) : <PresetPicture preset={preset} />}
        </li>
      ))}
    </ul>
  );
}
