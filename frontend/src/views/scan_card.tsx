import type { DataSet } from "../api/types";
import { isOpen, timeLeft, type UploadView } from "../api/upload_view";
import { correctionsOf, noteOf } from "../scan/corrections";
import { t } from "../texts";
import { refusalText } from "../texts/refusal";
import { CardPicture } from "./card_picture";
import { dateText, dayShortText } from "./format";
import { IconButton } from "./icon_button";
import { Icon, type IconName } from "./icons";
import { lookOf } from "./looks";
import { Link } from "./router";
import { Bar } from "./shell";
import { useApp } from "./state";
import { useThumbnail } from "./thumbnail";

/** Returns the title of a scan. Scans without one are distinguished by the time of their upload. */
export const titleOf = (set: DataSet): string =>
  set.is_sample
    ? (t.scans.sampleTitles[set.title] ?? (set.title || t.scans.sampleTitle))
    : set.title || t.scans.untitledOn(dateText(set.created_at));

/** The kind of scan, if its files state it. */
export function KindChip({ set }: { readonly set: DataSet }) {
  const kind = set.volume?.modality ?? "OTHER";
  return kind === "OTHER" ? null : <span class="chip">{t.sharing.gallery.kinds.names[kind]}</span>;
}

export interface ScanCardProps {
  readonly set: DataSet;
  readonly upload: UploadView | null;
  readonly onRemove: () => void;
  readonly onRename: () => void;
  /** Opens the log of who viewed the scan. */
  readonly onViews: () => void;
  /** Opens the labels of the scan. */
  readonly onLabels: () => void;
  /** Chooses a second scan to compare this one with. */
  /** Null if there is no other scan to compare it with. */
  readonly onCompare: (() => void) | null;
}

export function ScanCard(props: ScanCardProps) {
  const { set, upload } = props;
  const { state } = set;
  const ready = state === "ready";
  const title = titleOf(set);
  const still = isStill(set, upload);
  return (
    <article class={`card card-${set.state}`} data-state={set.state} data-id={set.id}>
      {state === "ready" ? <ReadyPicture set={set} /> : <StateIcon state={state} still={still} />}
      <div class="card-text">
        <h3>
          {ready ? (
            <Link href={`/view/${set.id}`} class="card-link" label={t.scans.open(title)}>
              {title}
            </Link>
          ) : (
            title
          )}
        </h3>
        <p class="chips">
          {set.is_sample ? <span class="chip chip-accent">{t.scans.sample}</span> : null}
          {set.is_public && !set.is_sample ? <span class="chip">{t.scans.shared}</span> : null}
          {set.shared && set.shared.people > 0 ? (
            <span class="chip">{t.sharing.withPeople(set.shared.people)}</span>
          ) : null}
          {set.shared && set.shared.links > 0 ? (
            <span class="chip">{t.sharing.withLinks(set.shared.links)}</span>
          ) : null}
          {set.taken_down ? <span class="chip chip-refused">{t.sharing.takenDown}</span> : null}
          <KindChip set={set} />
          {ready || still ? null : <span class={`chip chip-${set.state}`}>{t.scans.states[set.state]}</span>}
        </p>
        {set.taken_down ? <p class="card-fault">{t.sharing.everybody.takenDown(set.taken_down.reason)}</p> : null}
        {set.owned || !set.owner_name ? null : <p class="muted">{t.sharing.gallery.by(set.owner_name)}</p>}
        <Details set={set} upload={upload} />
      </div>
      <CardTools {...props} />
    </article>
  );
}

/** What can be done with a scan. Someone else's can only be compared. */
function CardTools({ set, upload, ...on }: ScanCardProps) {
  const ready = set.state === "ready";
  const title = titleOf(set);
  const remove = upload && isOpen(upload) ? t.scans.cancelUpload(title) : t.scans.remove(title);
  if (!ready && !set.owned) return null;
  return (
    <div class="card-tools">
      {ready && on.onCompare ? (
        <IconButton icon="compare" label={t.compare.openOf(title)} onClick={on.onCompare} />
      ) : null}
      {set.owned && ready ? (
        <>
          <IconButton icon="eye" label={t.sharing.views.openOf(title)} onClick={on.onViews} />
          <IconButton icon="tag" label={t.labels.title(title)} onClick={on.onLabels} />
        </>
      ) : null}
      {set.owned ? (
        <>
          <IconButton icon="pencil" label={t.scans.rename(title)} onClick={on.onRename} />
          <IconButton icon="trash" label={remove} onClick={on.onRemove} />
        </>
      ) : null}
    </div>
  );
}

/** The icons that are shown in place of a picture. */
const iconOfState = {
  uploading: "upload",
  queued: "clock",
  building: "clock",
  refused: "alert",
  expired: "alert",
} as const satisfies Record<UnreadyState, IconName>;

type UnreadyState = Exclude<DataSet["state"], "ready">;

/** Whether an upload has stopped for now. Its text says why, and the card must not look busy. */
const isStill = (set: DataSet, upload: UploadView | null): boolean =>
  set.state === "uploading" && (upload === null || upload.phase === "paused" || upload.phase === "stalled");

function ReadyPicture({ set }: { readonly set: DataSet }) {
  return <CardPicture picture={useThumbnail(set.id, lookOf(set), true)} title={titleOf(set)} />;
}

function StateIcon({ state, still }: { readonly state: UnreadyState; readonly still: boolean }) {
  const working = state !== "refused" && state !== "expired" && !still;
  return (
    <div class={`card-picture${working ? " card-working" : ""}`}>
      <Icon name={iconOfState[state]} />
    </div>
  );
}

function Details({ set, upload }: { readonly set: DataSet; readonly upload: UploadView | null }) {
  if (set.volume) {
    const [x, y, z] = set.volume.size.map((n, i) => n * (set.volume?.spacing_mm[i] ?? 0)) as [number, number, number];
    return (
      <>
        <p class="muted">
          {set.volume.phases > 1 ? `${t.scans.phases(set.volume.phases)} · ` : ""}
          {t.add.slices(set.volume.size[2])} · {t.add.size(x, y, z)}
          {set.owned ? ` · ${t.scans.addedOn(dayShortText(set.created_at))}` : ""}
          {set.labels && set.labels.count > 0 ? ` · ${t.labels.onCard(set.labels.count)}` : ""}
        </p>
        {set.volume.repairs.length > 0 ? <Corrections sentences={set.volume.repairs} /> : null}
      </>
    );
  }
  if (set.state === "refused") return <p class="card-fault">{set.refusal ? refusalText(set.refusal) : ""}</p>;
  if (set.state === "expired") return <p class="muted">{t.scans.expiredHint}</p>;
  if (set.waiting_for !== null)
    return (
      <p class="muted" role="status">
        {t.scans.waitingFor[set.waiting_for]}
      </p>
    );
  if (set.state !== "uploading") return <Bar value={null} label={t.scans.states[set.state]} />;
  return <UploadDetails set={set} upload={upload} />;
}

/**
 * The corrections in plain words, with the figures behind a button. An unknown sentence of the server stays English.
 */
function Corrections({ sentences }: { readonly sentences: readonly string[] }) {
  return (
    <>
      <p class="muted">{t.scans.repaired(correctionsOf(sentences))}</p>
      <details class="card-details">
        <summary>{t.scans.repairDetails}</summary>
        <ul>
          {sentences.map((one) => {
            const note = noteOf(one);
            return note ? (
              <li key={one}>{t.scans.repairNote(note)}</li>
            ) : (
              <li key={one} lang="en">
                {one}
              </li>
            );
          })}
        </ul>
      </details>
    </>
  );
}

function UploadDetails({ set, upload }: { readonly set: DataSet; readonly upload: UploadView | null }) {
  const app = useApp();
  if (upload?.phase === "refused")
    return (
      <p class="card-fault" role="alert">
        {t.scans.upload.refused[upload.refusal]}
      </p>
    );
  if (upload) {
    const part = upload.total > 0 ? upload.sent / upload.total : 0;
    const quiet = upload.phase === "paused" || upload.phase === "waiting";
    return (
      <>
        <Bar value={part} label={t.scans.states.uploading} />
        <div class="card-upload">
          <p class="muted" role={upload.phase === "sending" ? undefined : "status"}>
            {uploadText(upload, Math.floor(part * 100))}
          </p>
          {!isOpen(upload) || upload.phase === "waiting" ? null : quiet ? (
            <button
              type="button"
              class="button button-small"
              aria-label={t.scans.upload.resumeOf(titleOf(set))}
              onClick={() => app.uploads.resume(set.id)}
            >
              {t.scans.upload.resume}
            </button>
          ) : (
            <button
              type="button"
              class="button button-small"
              aria-label={t.scans.upload.pauseOf(titleOf(set))}
              onClick={() => app.uploads.pause(set.id)}
            >
              {t.scans.upload.pause}
            </button>
          )}
        </div>
      </>
    );
  }
  const part = set.upload ? set.upload.received_bytes / set.upload.bytes : 0;
  return (
    <>
      <Bar value={part} label={t.scans.states.uploading} />
      <p class="muted">
        {t.scans.interrupted(Math.floor(part * 100))}. {t.scans.interruptedHint}
      </p>
      <p>
        <Link href="/add" class="button button-small" label={t.scans.upload.resumeOf(titleOf(set))}>
          {t.scans.resumeInterrupted}
        </Link>
      </p>
    </>
  );
}

function uploadText(upload: UploadView, percent: number): string {
  const text = t.scans.upload;
  switch (upload.phase) {
    case "waiting":
      return text.waiting;
    case "paused":
      return text.paused(percent);
    case "elsewhere":
      return text.elsewhere(percent);
    case "stalled":
      return text.stalled[upload.stallReason];
    default: {
      const seconds = timeLeft(upload);
      return text.sending(percent, seconds === null ? "" : text.left(seconds));
    }
  }
}
