import { useEffect, useState } from "preact/hooks";
import { bodyParts, type DataSet, type GalleryQuery, type PresetInfo } from "../api/types";
import { t } from "../texts";
import { CardPicture } from "./card_picture";
import { Choice } from "./choice";
import { Field } from "./field";
import { IconButton } from "./icon_button";
import { Loading } from "./loading";
import { lookOf } from "./looks";
import { ReportDialog } from "./report_dialog";
import { Link } from "./router";
import { KindChip, titleOf } from "./scan_card";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { PresetPicture, useThumbnail } from "./thumbnail";
import { useGallerySearch, wholeGallery } from "./use_gallery_search";

/** The public scans. Without an account, only the samples are listed. */
export function Gallery() {
  const app = useApp();
  const known = app.me.value !== null;
  const { question, ask, found, more, fault, loadMore } = useGallerySearch(known);
  const [reported, setReported] = useState<DataSet | null>(null);
  const text = t.sharing.gallery;
  return (
    <div class="page">
      <div>
        <PageTitle text={text.title} />
        <p class="muted">{known ? `${text.lead} ${t.sharing.views.toldPerson}` : text.leadNobody}</p>
      </div>
      {known ? null : (
        <Notice kind="info">
          {text.signUp} <Link href="/sign-up">{t.account.signUp}</Link>
        </Notice>
      )}
      <GallerySearch question={question} ask={ask} />
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {found === null && !fault ? <Loading /> : null}
      {found ? (
        <p class="muted" role="status">
          {foundText(found.length, more, question)}
        </p>
      ) : null}
      <ul class="cards" aria-label={text.title}>
        {found?.map((set) => (
          <li key={set.id}>
            <GalleryCard set={set} known={known} onReport={() => setReported(set)} />
          </li>
        ))}
      </ul>
      {more ? (
        <p>
          <button type="button" class="button" onClick={loadMore}>
            {text.more}
          </button>
        </p>
      ) : null}
      {reported ? (
        <ReportDialog
          title={t.sharing.report.title}
          reasons={t.sharing.report.reasons}
          onClose={() => setReported(null)}
          send={(reason, words) => app.api.sharing.report(reported.id, reason, words)}
        />
      ) : null}
    </div>
  );
}

function foundText(count: number, more: boolean, question: GalleryQuery): string {
  const text = t.sharing.gallery;
  if (count > 0) return text.found(count, more);
  return question === wholeGallery ? text.nothingYet : text.nothing;
}

interface GallerySearchProps {
  readonly question: GalleryQuery;
  readonly ask: (part: Partial<GalleryQuery>) => void;
}

function GallerySearch({ question, ask }: GallerySearchProps) {
  const text = t.sharing.gallery;
  return (
    <form class="gallery-search" role="search" aria-label={text.search} onSubmit={(event) => event.preventDefault()}>
      <Field label={text.words} value={question.q} onInput={(q) => ask({ q })} most={100} />
      <Choice
        label={t.sharing.details.bodyPart}
        value={question.body_part}
        onChoose={(bodyPart) => ask({ body_part: bodyPart })}
        options={[
          ["", text.anyPart],
          ...bodyParts.map((part): [string, string] => [part, t.sharing.parts[part] ?? part]),
        ]}
      />
      <Choice
        label={text.kinds.label}
        value={question.modality}
        onChoose={(modality) => ask({ modality })}
        options={[["", text.anyKind], ...Object.entries(text.kinds.names)]}
      />
    </form>
  );
}

interface GalleryCardProps {
  readonly set: DataSet;
  readonly known: boolean;
  readonly onReport: () => void;
}

function GalleryCard({ set, known, onReport }: GalleryCardProps) {
  const picture = useThumbnail(set.id, lookOf(set), true);
  const title = titleOf(set);
  const text = t.sharing.gallery;
  return (
    <article class="card card-ready" data-id={set.id}>
      <CardPicture picture={picture} title={title} />
      <div class="card-text">
        <h2 class="card-title">
          <Link href={known ? `/view/${set.id}` : `/sample/${set.id}`} class="card-link" label={text.open(title)}>
            {title}
          </Link>
        </h2>
        <p class="chips">
          {set.is_sample ? <span class="chip chip-accent">{t.scans.sample}</span> : null}
          <KindChip set={set} />
          {set.body_part ? <span class="chip">{t.sharing.parts[set.body_part]}</span> : null}
        </p>
        {set.description ? <p class="card-description">{set.description}</p> : null}
        {set.owner_name ? <p class="muted">{text.by(set.owner_name)}</p> : null}
        <CrowdPresets set={set} known={known} />
      </div>
      {known && !set.owned ? (
        <IconButton class="card-remove" icon="flag" label={text.report(title)} onClick={onReport} />
      ) : null}
    </article>
  );
}

const mostOfCrowd = 4;

/**
 * The best presets that people saved for a scan. For users with an account, each opens the scan.
 * Empty if there is none.
 */
function CrowdPresets({ set, known }: { readonly set: DataSet; readonly known: boolean }) {
  const app = useApp();
  const [presets, setPresets] = useState<readonly PresetInfo[]>([]);
  useEffect(() => {
    app.api.presets.list(set.id).then(
      (all) => {
        setPresets(all.filter((one) => one.taken_down === null).slice(0, mostOfCrowd));
      },
      () => undefined,
    ); // the card is complete without them
  }, [app, set.id]);
  if (presets.length === 0) return null;
  return (
    <ul class="crowd" aria-label={t.presets.crowd}>
      {presets.map((preset) => (
        <li key={preset.id}>
          {known ? (
            <Link href={`/view/${set.id}#look=${preset.id}`} class="crowd-link" label={t.presets.apply(preset.name)}>
              <PresetPicture preset={preset} />
            </Link>
          ) : (
            <PresetPicture preset={preset} />
          )}
        </li>
      ))}
    </ul>
  );
}
