import { useState } from "preact/hooks";
import type { ArchiveSeries, ArchiveStudy } from "../../api/archives";
import { proposedTitle } from "../../scan/propose_title";
import { t } from "../../texts";
import { Field } from "../field";
import { dicomDateText } from "../format";
import { Link } from "../router";
import { Bar, Notice } from "../shell";
import { useFetch } from "./use_fetch";

export interface ArchiveSeriesCardProps {
  readonly archive: string;
  readonly study: ArchiveStudy;
  readonly series: ArchiveSeries;
}

/** A series that can be fetched, and the progress of its fetch. */
export function ArchiveSeriesCard({ archive, study, series }: ArchiveSeriesCardProps) {
  const { running, done, fault, start, cancel } = useFetch(archive, study.study, series.series);
  const name = series.description || t.add.seriesUntitled;
  const facts = [
    series.body_part,
    series.images === null ? "" : t.archive.images(series.images),
    series.thickness === null ? "" : t.archive.thickness(series.thickness),
  ].filter(Boolean);
  return (
    <article class="archive-card">
      <h5>{name}</h5>
      <p class="chips">
        {series.recommended ? <span class="chip chip-good">{t.add.best}</span> : null}
        <span class="chip">{series.modality}</span>
      </p>
      {series.recommended ? <p class="muted">{t.archive.bestWhy}</p> : null}
      <p class="muted">{facts.join(" · ")}</p>
      {done ? (
        <Notice kind="good">
          {t.archive.done} <Link href="/scans">{t.titles.scans}</Link>
        </Notice>
      ) : running ? (
        <Progress {...running} name={name} cancel={cancel} />
      ) : (
        <FetchForm study={study} series={series} name={name} start={start} />
      )}
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
    </article>
  );
}

interface FetchFormProps extends Pick<ArchiveSeriesCardProps, "study" | "series"> {
  readonly name: string;
  readonly start: (title: string) => void;
}

function FetchForm({ study, series, name, start }: FetchFormProps) {
  const date = dicomDateText((study.date ?? "").replaceAll("-", ""));
  const patient = { name: study.patient_name, id: study.patient_id, birthDate: "" };
  const { description, body_part: bodyPart, modality } = series;
  const [title, setTitle] = useState(() => proposedTitle({ description, bodyPart, modality, patient }, date));
  return (
    <form
      class="series-form"
      onSubmit={(event) => {
        event.preventDefault();
        start(title.trim());
      }}
    >
      <Field label={t.add.title} value={title} onInput={setTitle} most={80} hint={t.add.titleHint} />
      <button type="submit" class="button button-main" aria-label={t.archive.fetchOf(name)}>
        {t.archive.fetch}
      </button>
    </form>
  );
}

interface ProgressProps {
  readonly share: number | null;
  readonly text: string;
  readonly name: string;
  readonly cancel: () => void;
}

function Progress({ share, text, name, cancel }: ProgressProps) {
  return (
    <>
      <Bar value={share} label={t.archive.fetchingOf(name)} />
      <div class="card-upload">
        <p class="muted">{text}</p>
        <button type="button" class="button button-small" aria-label={t.archive.cancelOf(name)} onClick={cancel}>
          {t.cancel}
        </button>
      </div>
    </>
  );
}
