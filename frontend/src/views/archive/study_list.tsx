import { useEffect, useRef, useState } from "preact/hooks";
import type { ArchiveSeries, ArchiveStudy } from "../../api/archives";
import { t } from "../../texts";
import { dicomDateText } from "../format";
import { Icon } from "../icons";
import { Loading } from "../loading";
import { Notice } from "../shell";
import { useApp } from "../state";
import { ArchiveSeriesCard } from "./archive_series";

const dayText = (date: string | null): string => dicomDateText((date ?? "").replaceAll("-", ""));

export interface StudyListProps {
  readonly archive: string;
  readonly items: readonly ArchiveStudy[];
  readonly more: boolean;
}

/** The studies that a search found. */
export function StudyList({ archive, items, more }: StudyListProps) {
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []);
  return (
    <>
      <h3 ref={heading} tabIndex={-1}>
        {items.length > 0 ? t.archive.found(items.length) : t.archive.nothing}
      </h3>
      {items.length === 0 ? <p>{t.archive.nothingHint}</p> : <p class="muted">{t.archive.privacy}</p>}
      {more ? <Notice kind="warn">{t.archive.more}</Notice> : null}
      <ul class="archive-studies">
        {items.map((study) => (
          <li key={study.study}>
            <Study archive={archive} study={study} />
          </li>
        ))}
      </ul>
    </>
  );
}

function Study({ archive, study }: { readonly archive: string; readonly study: ArchiveStudy }) {
  const { open, toggle, series, wrong } = useSeries(archive, study.study);
  const born = dayText(study.birth_date);
  const title = [study.description || t.archive.untitled, dayText(study.date)].filter(Boolean).join(", ");
  const facts = [
    study.accession,
    study.series === null ? "" : t.archive.series(study.series),
    study.images === null ? "" : t.archive.images(study.images),
  ].filter(Boolean);
  return (
    <article>
      <h4>{title}</h4>
      <p class="chips">
        {study.modalities.map((one) => (
          <span key={one} class="chip">
            {one}
          </span>
        ))}
      </p>
      <p class="series-patient">
        <Icon name="shield" />
        <span>
          {[study.patient_name || t.archive.patientUnknown, born ? t.add.born(born) : "", study.patient_id]
            .filter(Boolean)
            .join(" · ")}
        </span>
      </p>
      {facts.length > 0 ? <p class="muted">{facts.join(" · ")}</p> : null}
      <p>
        <button
          type="button"
          class="button"
          aria-expanded={open}
          onClick={toggle}
          aria-label={`${open ? t.archive.close : t.archive.open}: ${title}`}
        >
          {open ? t.archive.close : t.archive.open}
        </button>
      </p>
      {open && wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {open && !series && !wrong ? <Loading /> : null}
      {series ? (
        <div hidden={!open}>
          <SeriesOfStudy archive={archive} study={study} series={series} />
        </div>
      ) : null}
    </article>
  );
}

interface SeriesOfStudyProps {
  readonly archive: string;
  readonly study: ArchiveStudy;
  readonly series: readonly ArchiveSeries[];
}

function SeriesOfStudy({ archive, study, series }: SeriesOfStudyProps) {
  const suitable = series.filter((one) => one.suitable);
  const others = series.length - suitable.length;
  return (
    <>
      {suitable.length === 0 ? <Notice kind="bad">{t.archive.noSeries}</Notice> : null}
      <ul class="archive-series">
        {suitable.map((one) => (
          <li key={one.series}>
            <ArchiveSeriesCard archive={archive} study={study} series={one} />
          </li>
        ))}
      </ul>
      {others > 0 ? <p class="muted">{t.archive.others(others)}</p> : null}
    </>
  );
}

/** The series of a study, which are requested when it is opened. */
function useSeries(archive: string, study: string) {
  const app = useApp();
  const [open, setOpen] = useState(false);
  const [series, setSeries] = useState<readonly ArchiveSeries[] | null>(null);
  const [wrong, setWrong] = useState("");
  const toggle = () => {
    setOpen(!open);
    if (open || series) return;
    setWrong("");
    app.api.archives.series(archive, study).then(setSeries, (thrown: unknown) => setWrong(app.explain(thrown)));
  };
  return { open, toggle, series, wrong };
}
