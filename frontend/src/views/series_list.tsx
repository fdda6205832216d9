import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { SentElsewhere } from "../api/uploads";
import { bundle_size } from "../scan/bundle";
import type { ScanResult, Series, Suitable, Thumbnail } from "../scan/types";
import { part_blobs, sizes_of } from "../scan/upload_plan";
import { t } from "../texts";
import { Field } from "./field";
import { bytes_text, dicom_date_text } from "./format";
import { Icon } from "./icons";
import { navigate } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";

export interface SeriesListProps {
  readonly files: readonly File[];
  readonly result: ScanResult;
  readonly onAgain: () => void;
}

/** What was found: what can be shown, and on request what not and why. */
export function SeriesList({ files, result, onAgain }: SeriesListProps) {
  const suitable = result.series.filter((series) => series.verdict.suitable);
  const hidden = result.series.filter((series) => !series.verdict.suitable);
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []);
  return (
    <>
      <div class="page-head">
        <h2 ref={heading} tabIndex={-1}>{suitable.length > 0 ? t.add.found(suitable.length) : t.add.nothing}</h2>
        <button type="button" class="button" onClick={onAgain}>{t.add.another}</button>
      </div>
      {suitable.length > 0 ? <Notice kind="info">{t.add.privacy_short}</Notice> : <Nothing result={result} hidden={hidden.length} />}
      <ul class="series">
        {suitable.map((series) =>
          series.verdict.suitable ? (
            <li key={series.key}><SeriesCard series={series} verdict={series.verdict} files={files} /></li>
          ) : null,
        )}
      </ul>
      {hidden.length > 0 ? (
        <details class="hidden-series" open={suitable.length === 0}>
          <summary>{t.add.hidden(hidden.length)}</summary>
          <ul>
            {hidden.map((series) =>
              series.verdict.suitable ? null : (
                <li key={series.key} data-reason={series.verdict.reason}>
                  <strong>{series.description || t.add.series_untitled}</strong>
                  <span class="muted"> · {[series.modality, t.add.slices(series.slices)].filter(Boolean).join(" · ")}</span>
                  <p>{t.add.reasons[series.verdict.reason](series.verdict.count)}</p>
                </li>
              ),
            )}
          </ul>
        </details>
      ) : null}
      {suitable.length > 0 || hidden.length > 0 ? <Rest result={result} /> : null}
    </>
  );
}

function Rest({ result }: { readonly result: ScanResult }) {
  const lines = [
    result.not_slices > 0 ? t.add.not_slices(result.not_slices) : "",
    result.not_dicom > 0 ? t.add.others(result.not_dicom) : "",
    result.unreadable > 0 ? t.add.unreadable(result.unreadable) : "",
  ].filter(Boolean);
  return lines.length > 0 ? <p class="muted">{lines.join(" ")}</p> : null;
}

function Nothing({ result, hidden }: { readonly result: ScanResult; readonly hidden: number }) {
  if (result.files === 0) return <Notice kind="bad">{t.add.nothing_empty}</Notice>;
  if (hidden > 0) return <Notice kind="bad">{t.add.nothing_hint}</Notice>;
  if (result.not_slices > 0) return <Notice kind="bad">{t.add.only_reports}</Notice>;
  if (result.unreadable > 0) return <Notice kind="bad">{t.add.unreadable(result.unreadable)}</Notice>;
  return <Notice kind="bad">{t.add.nothing_no_dicom(result.files)}</Notice>;
}

interface SeriesCardProps {
  readonly series: Series;
  readonly verdict: Suitable;
  readonly files: readonly File[];
}

function SeriesCard({ series, verdict, files }: SeriesCardProps) {
  const app = useApp();
  const [title, set_title] = useState("");
  const [busy, set_busy] = useState(false);
  const [fault, set_fault] = useState("");
  const [interrupted_at, set_interrupted_at] = useState<number | null>(null);
  // Without making the pieces: a disc has thousands, and they are needed only when it is sent.
  const bytes = useMemo(() => bundle_size(sizes_of(series.upload)), [series]);

  useEffect(() => {
    void app.uploads
      .interrupted(series.fingerprint, bytes)
      .then((earlier) => set_interrupted_at(earlier ? Math.floor((100 * earlier.received) / bytes) : null))
      .catch(() => undefined); // asked again when the upload begins
  }, [app, series.fingerprint, bytes]);
  const quota = app.me.value?.quota;
  const free = quota ? Math.max(0, quota.bytes - quota.used_bytes) : Infinity;
  const too_much = interrupted_at === null && bytes > free ? t.add.over_quota(bytes_text(bytes), bytes_text(free)) : "";

  const upload = async () => {
    set_busy(true);
    set_fault("");
    try {
      await app.uploads.start(await part_blobs(series.upload, files), title.trim(), series.fingerprint);
      navigate("/scans");
    } catch (thrown) {
      set_fault(fault_text(thrown));
      set_busy(false);
    }
  };
  const fault_text = (thrown: unknown): string => {
    if (thrown instanceof SentElsewhere) return t.add.sent_elsewhere;
    if (thrown instanceof ApiProblem && thrown.kind === "over-quota" && free < bytes) return t.add.over_quota(bytes_text(bytes), bytes_text(free));
    if (thrown instanceof ApiProblem && thrown.kind === "storage-full") return t.add.storage_full;
    if (thrown instanceof ApiProblem && thrown.kind === "upload-too-large") return t.add.too_large;
    return app.explain(thrown);
  };

  const [x, y, z] = verdict.size_mm;
  const born = dicom_date_text(series.patient.birth_date);
  return (
    <article class="series-card">
      <Preview thumbnail={series.thumbnail} />
      <div class="series-text">
        <h3>{series.description || t.add.series_untitled}</h3>
        <p class="chips">
          {series.modality ? <span class="chip">{series.modality}</span> : null}
          {series.body_part ? <span class="chip">{series.body_part}</span> : null}
        </p>
        <p class="series-patient">
          <Icon name="shield" />
          <span>{[series.patient.name || t.add.patient_unknown, born ? t.add.born(born) : "", series.patient.id].filter(Boolean).join(" · ")}</span>
        </p>
        <p class="muted">{[t.add.slices(verdict.size[2]), t.add.size(x, y, z), bytes_text(bytes), ...t.add.left_out(verdict.left_out), ...verdict.repairs.map(t.add.repair)].join(" · ")}</p>
        <form
          class="series-form"
          onSubmit={(event) => {
            event.preventDefault();
            void upload();
          }}
        >
          {interrupted_at === null ? (
            <Field label={t.add.title} value={title} onInput={set_title} most={80} placeholder={t.add.title_example} hint={t.add.title_hint} />
          ) : (
            <p>{t.add.go_on_text(interrupted_at)}</p>
          )}
          <button type="submit" class="button button-main" disabled={busy} aria-busy={busy}>
            {busy ? t.add.starting : interrupted_at === null ? t.add.upload : t.add.go_on}
          </button>
        </form>
        {fault || too_much ? <Notice kind="bad">{fault || too_much}</Notice> : null}
      </div>
    </article>
  );
}

function Preview({ thumbnail }: { readonly thumbnail: Thumbnail | null }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = canvas.current?.getContext("2d");
    if (!thumbnail || !context) return;
    const image = context.createImageData(thumbnail.width, thumbnail.height);
    thumbnail.gray.forEach((level, i) => image.data.set([level, level, level, 255], 4 * i));
    context.putImageData(image, 0, 0);
  }, [thumbnail]);
  return (
    <div class="series-preview">
      {thumbnail ? (
        <canvas ref={canvas} width={thumbnail.width} height={thumbnail.height} role="img" aria-label={t.add.thumbnail} />
      ) : (
        <span class="muted">{t.add.no_thumbnail}</span>
      )}
    </div>
  );
}
