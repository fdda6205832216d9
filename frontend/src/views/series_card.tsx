import type { ComponentChildren } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { allPhases, hasChoice, keepPhases } from "../scan/keep_phases";
import type { Recommendation } from "../scan/recommend";
import type { ScanResult, Series, Suitable, Thumbnail } from "../scan/types";
import { t } from "../texts";
import { Field } from "./field";
import { bytesText, dicomDateText } from "./format";
import { Icon } from "./icons";
import { PhasesField } from "./phases_field";
import { Link } from "./router";
import { Notice } from "./shell";
import { useSeriesUpload } from "./use_series_upload";

export interface SeriesCardProps {
  readonly series: Series;
  readonly name: string;
  /** The proposed title. */
  readonly title: string;
  readonly verdict: Suitable;
  readonly files: readonly File[];
  /** The files of archives (`ScanResult.unpacked`). */
  readonly unpacked: ScanResult["unpacked"];
  /** Whether nothing else can be uploaded from this folder. */
  readonly only: boolean;
  /** Given if this series is recommended among several. */
  readonly best: Recommendation["why"] | null;
  /** Receives a function that starts the upload with the title in the form, and null once it has begun. */
  readonly onReady: (start: (() => Promise<void>) | null) => void;
}

/** A series that can be uploaded: its facts, and the form for uploading it. */
export function SeriesCard(props: SeriesCardProps) {
  const { series, name, title, verdict, files, unpacked, only, best, onReady } = props;
  const [choice, setChoice] = useState(allPhases);
  const chosen = useMemo(() => keepPhases(series, choice), [series, choice]);
  const upload = useSeriesUpload(chosen, files, unpacked, only);
  return (
    <article class="series-card">
      <Preview thumbnail={series.thumbnail} />
      <div class="series-text">
        <SeriesFacts series={series} name={name} verdict={verdict} bytes={upload.bytes} best={best} />
        {upload.begun ? (
          <Notice kind="good">
            {t.add.begun} <Link href="/scans">{t.titles.scans}</Link>
          </Notice>
        ) : (
          <UploadForm title={title} upload={upload} onReady={onReady}>
            {verdict.phases && hasChoice(series) ? (
              <PhasesField phases={verdict.phases} choice={choice} onChoose={setChoice} disabled={upload.busy} />
            ) : null}
          </UploadForm>
        )}
        {upload.fault ? <Notice kind="bad">{upload.fault}</Notice> : null}
      </div>
    </article>
  );
}

interface SeriesFactsProps extends Pick<SeriesCardProps, "series" | "name" | "verdict" | "best"> {
  readonly bytes: number;
}

function SeriesFacts({ series, name, verdict, bytes, best }: SeriesFactsProps) {
  const [x, y, z] = verdict.sizeMm;
  const born = dicomDateText(series.patient.birthDate);
  const facts = [
    ...(verdict.phases ? [t.add.phases(verdict.phases)] : []),
    t.add.slices(verdict.size[2]),
    t.add.size(x, y, z),
    bytesText(bytes),
    ...t.add.leftOut(verdict.leftOut),
    ...verdict.repairs.map(t.add.repair),
  ];
  return (
    <>
      <h3>{name}</h3>
      <p class="chips">
        {best ? <span class="chip chip-good">{t.add.best}</span> : null}
        {series.modality ? <span class="chip">{series.modality}</span> : null}
        {series.bodyPart ? <span class="chip">{series.bodyPart}</span> : null}
      </p>
      {best ? <p class="muted">{t.add.bestWhy[best.kind](best.mm)}</p> : null}
      <p class="series-patient">
        <Icon name="shield" />
        <span>
          {[series.patient.name || t.add.patientUnknown, born ? t.add.born(born) : "", series.patient.id]
            .filter(Boolean)
            .join(" · ")}
        </span>
      </p>
      <p class="muted">{facts.join(" · ")}</p>
    </>
  );
}

interface UploadFormProps extends Pick<SeriesCardProps, "title"> {
  readonly upload: ReturnType<typeof useSeriesUpload>;
  readonly onReady: SeriesCardProps["onReady"];
  readonly children: ComponentChildren;
}

/** Asks for a title, unless an interrupted upload of the same files is resumed. `children`: further fields. */
function UploadForm({ title: proposal, upload, onReady, children }: UploadFormProps) {
  const [title, setTitle] = useState(proposal);
  const { busy, interruptedAt, start } = upload;
  useEffect(() => {
    onReady(() => start(title.trim()));
    return () => onReady(null);
  });
  return (
    <form
      class="series-form"
      onSubmit={(event) => {
        event.preventDefault();
        void start(title.trim());
      }}
    >
      {interruptedAt === null ? (
        <Field
          label={t.add.title}
          value={title}
          onInput={setTitle}
          most={80}
          placeholder={t.add.titleExample}
          hint={`${proposal === "" ? "" : t.add.titleProposed} ${t.add.titleHint}`.trim()}
        />
      ) : (
        <p>{t.add.resumeText(interruptedAt)}</p>
      )}
      {children}
      <button type="submit" class="button button-main" disabled={busy} aria-busy={busy}>
        {busy ? t.add.starting : interruptedAt === null ? t.add.upload : t.add.resume}
      </button>
    </form>
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
        <canvas
          ref={canvas}
          width={thumbnail.width}
          height={thumbnail.height}
          role="img"
          aria-label={t.add.thumbnail}
        />
      ) : (
        <span class="muted">{t.add.noThumbnail}</span>
      )}
    </div>
  );
}
