import { useEffect, useRef, useState } from "preact/hooks";
import type { ScanResult, Series } from "../scan/types";
import { proposedTitles } from "../scan/propose_title";
import { recommend } from "../scan/recommend";
import { seriesNames } from "../scan/series_names";
import { t } from "../texts";
import { dicomDateText } from "./format";
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
  const best = recommend(suitable);
  const names = seriesNames(result.series, t.add.seriesUntitled);
  const titles = proposedTitles(suitable, dicomDateText);
  suitable.sort((a, b) => Number(b.key === best?.key) - Number(a.key === best?.key));
  const heading = useRef<HTMLHeadingElement>(null);
  useEffect(() => heading.current?.focus(), []);
  const all = useUploadAll();
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
        <Notice kind="info">
          {t.add.privacyShort} {suitable.length > 1 ? t.add.several : ""}
        </Notice>
      ) : (
        <Nothing result={result} hidden={hidden.length} />
      )}
      <FaultyArchives files={files} faults={result.faults} />
      {suitable.length > 1 ? <UploadAll all={all} count={suitable.length} /> : null}
      <ul class="series">
        {suitable.map((series) =>
          series.verdict.suitable ? (
            <li key={series.key}>
              <SeriesCard
                series={series}
                name={names.get(series.key) ?? ""}
                title={titles.get(series.key) ?? ""}
                verdict={series.verdict}
                files={files}
                unpacked={result.unpacked}
                only={suitable.length === 1}
                best={series.key === best?.key ? best.why : null}
                onReady={(start) => all.set(series.key, start)}
              />
            </li>
          ) : null,
        )}
      </ul>
      <HiddenSeries hidden={hidden} names={names} open={suitable.length === 0} />
      {suitable.length > 0 || hidden.length > 0 ? <Rest result={result} /> : null}
    </>
  );
}

function UploadAll({ all, count }: { readonly all: ReturnType<typeof useUploadAll>; readonly count: number }) {
  return (
    <p>
      <button
        type="button"
        class="button"
        disabled={all.busy || all.done}
        aria-busy={all.busy}
        onClick={() => void all.start()}
      >
        {t.add.uploadAll(count)}
      </button>
    </p>
  );
}

/** Starts the uploads that have not begun, one after the other, so that each checks whether it still fits. */
function useUploadAll() {
  const starts = useRef(new Map<string, () => Promise<void>>());
  const [busy, setBusy] = useState(false);
  const [done, setDone] = useState(false);
  const set = (key: string, start: (() => Promise<void>) | null) => {
    if (start) starts.current.set(key, start);
    else starts.current.delete(key);
  };
  const start = async () => {
    setBusy(true);
    for (const key of [...starts.current.keys()]) await starts.current.get(key)?.();
    setBusy(false);
    setDone(starts.current.size === 0);
  };
  return { busy, done, set, start };
}

interface HiddenSeriesProps {
  readonly hidden: readonly Series[];
  readonly names: ReadonlyMap<string, string>;
  readonly open: boolean;
}

/** The series that can't be shown, with the reasons. */
function HiddenSeries({ hidden, names, open }: HiddenSeriesProps) {
  if (hidden.length === 0) return null;
  return (
    <details class="hidden-series" open={open}>
      <summary>{t.add.hidden(hidden.length)}</summary>
      <ul>
        {hidden.map((series) =>
          series.verdict.suitable ? null : (
            <li key={series.key} data-reason={series.verdict.reason}>
              <strong>{names.get(series.key)}</strong>
              <span class="muted"> · {[series.modality, t.add.slices(series.slices)].filter(Boolean).join(" · ")}</span>
              <p>{t.add.reasons[series.verdict.reason](series.verdict.count)}</p>
            </li>
          ),
        )}
      </ul>
    </details>
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

interface FaultyArchivesProps extends Pick<SeriesListProps, "files">, Pick<ScanResult, "faults"> {}

function FaultyArchives({ files, faults }: FaultyArchivesProps) {
  return faults.map(({ file, fault }) => (
    <Notice key={`${file} ${fault}`} kind="bad">
      {t.add.archives[fault](files[file]?.name ?? "")}
    </Notice>
  ));
}

interface NothingProps extends Pick<SeriesListProps, "result"> {
  readonly hidden: number;
}

function Nothing({ result, hidden }: NothingProps) {
  if (result.files === 0 && result.faults.length > 0) return null;
  if (result.files === 0) return <Notice kind="bad">{t.add.nothingEmpty}</Notice>;
  if (hidden > 0) return <Notice kind="bad">{t.add.nothingHint}</Notice>;
  if (result.notSlices > 0) return <Notice kind="bad">{t.add.onlyReports}</Notice>;
  if (result.unreadable > 0) return <Notice kind="bad">{t.add.unreadable(result.unreadable)}</Notice>;
  return <Notice kind="bad">{t.add.nothingNoDicom(result.files)}</Notice>;
}
