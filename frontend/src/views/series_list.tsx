import { useEffect, useRef } from "preact/hooks";
import type { ScanResult } from "../scan/types";
import { t } from "../texts";
import { SeriesCard } from "./series_card";
import { Notice } from "./shell";

export interface SeriesListProps {
  readonly files: readonly File[];
  readonly result: ScanResult;
  readonly onAgain: () => void;
}

/** The suitable series and, on request, the unsuitable ones with the reasons. */
export function SeriesList({ files, result, onAgain }: SeriesListProps) {
  const suitable = result.series.filter((series) => series.verdict.suitable);
  const hidden = result.series.filter((series) => !series.verdict.suitable);
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []);
  return (
    <>
      <div class="page-head">
        <h2 ref={heading} tabIndex={-1}>
          {suitable.length > 0 ? t.add.found(suitable.length) : t.add.nothing}
        </h2>
        <button type="button" class="button" onClick={onAgain}>
          {t.add.another}
        </button>
      </div>
      {suitable.length > 0 ? (
        <Notice kind="info">{t.add.privacyShort}</Notice>
      ) : (
        <Nothing result={result} hidden={hidden.length} />
      )}
      <ul class="series">
        {suitable.map((series) =>
          series.verdict.suitable ? (
            <li key={series.key}>
              <SeriesCard series={series} verdict={series.verdict} files={files} />
            </li>
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
                  <strong>{series.description || t.add.seriesUntitled}</strong>
                  <span class="muted">
                    {" "}
                    · {[series.modality, t.add.slices(series.slices)].filter(Boolean).join(" · ")}
                  </span>
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
    result.notSlices > 0 ? t.add.notSlices(result.notSlices) : "",
    result.notDicom > 0 ? t.add.others(result.notDicom) : "",
    result.unreadable > 0 ? t.add.unreadable(result.unreadable) : "",
  ].filter(Boolean);
  return lines.length > 0 ? <p class="muted">{lines.join(" ")}</p> : null;
}

function Nothing({ result, hidden }: { readonly result: ScanResult; readonly hidden: number }) {
  if (result.files === 0) return <Notice kind="bad">{t.add.nothingEmpty}</Notice>;
  if (hidden > 0) return <Notice kind="bad">{t.add.nothingHint}</Notice>;
  if (result.notSlices > 0) return <Notice kind="bad">{t.add.onlyReports}</Notice>;
  if (result.unreadable > 0) return <Notice kind="bad">{t.add.unreadable(result.unreadable)}</Notice>;
  return <Notice kind="bad">{t.add.nothingNoDicom(result.files)}</Notice>;
}
