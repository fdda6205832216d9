import { useEffect, useRef, useState } from "preact/hooks";
import { scanInWorker } from "../scan/scan_client";
import type { ScanResult } from "../scan/types";
import { t } from "../texts";
import { ArchivePanel } from "./archive/archive_panel";
import { Icon } from "./icons";
import { SeriesList } from "./series_list";
import { takeFilesForAdd } from "./files_for_add";
import { Bar, Notice, PageTitle, useFocusKept } from "./shell";
import { useDroppedFiles } from "./use_dropped_files";
import { useLatest } from "./use_latest";
import { touchScreen, useMedia } from "./use_media";

type Stage =
  | { readonly kind: "choose"; readonly fault?: string }
  | { readonly kind: "scanning"; readonly done: number; readonly total: number; readonly stop: () => void }
  | { readonly kind: "found"; readonly files: readonly File[]; readonly result: ScanResult };

export function Add() {
  const [stage, setStage] = useState<Stage>({ kind: "choose" });
  const scanning = useRef<AbortController | null>(null);
  useEffect(() => () => scanning.current?.abort(), []);
  useFocusKept(stage.kind);

  const scan = async (files: readonly File[]) => {
    const stopping = new AbortController();
    scanning.current = stopping;
    const stop = () => {
      stopping.abort();
      setStage({ kind: "choose" });
    };
    setStage({ kind: "scanning", done: 0, total: files.length, stop });
    try {
      const progress = (done: number, total: number) => {
        if (!stopping.signal.aborted) setStage({ kind: "scanning", done, total, stop });
      };
      const result = await scanInWorker(files, progress, stopping.signal);
      setStage({ kind: "found", files, result });
    } catch {
      setStage({ kind: "choose", fault: t.add.failed });
    }
  };

  const begin = useLatest(scan);
  useEffect(() => {
    const files = takeFilesForAdd();
    if (files) void begin.current(files);
  }, [begin]);

  return (
    <div class="page page-narrow">
      <PageTitle text={t.titles.add} />
      {stage.kind === "choose" ? (
        <>
          <p class="lead">{t.add.lead}</p>
          {stage.fault ? <Notice kind="bad">{stage.fault}</Notice> : null}
          <Drop onFiles={(files) => void scan(files)} />
          <Notice kind="info">{t.add.privacy}</Notice>
          <ArchivePanel />
        </>
      ) : null}
      {stage.kind === "scanning" ? (
        <section class="scanning" role="status">
          <h2>{t.add.scanning}</h2>
          <Bar value={stage.total > 0 ? stage.done / stage.total : null} label={t.add.scanning} />
          <p class="muted">{t.add.scanned(stage.done, stage.total)}</p>
          <button type="button" class="button" onClick={stage.stop}>
            {t.add.stop}
          </button>
        </section>
      ) : null}
      {stage.kind === "found" ? (
        <SeriesList files={stage.files} result={stage.result} onAgain={() => setStage({ kind: "choose" })} />
      ) : null}
    </div>
  );
}

function Drop({ onFiles }: { readonly onFiles: (files: File[]) => void }) {
  const [over, setOver] = useState(false);
  const touch = useMedia(touchScreen);
  useDroppedFiles((files) => {
    setOver(false);
    onFiles(files);
  });
  return (
    <div
      class={`drop${over ? " drop-over" : ""}`}
      onDragOver={() => setOver(true)}
      onDragLeave={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setOver(false);
      }}
    >
      <Icon name="folder" />
      <p class="drop-text" aria-hidden="true">
        {over ? t.add.dropping : t.add.drop}
      </p>
      <p class="muted" aria-hidden="true">
        {t.add.or}
      </p>
      <div class="drop-buttons">
        {(touch ? (["files", "folder"] as const) : (["folder", "files"] as const)).map((kind, at) => (
          <Picker key={kind} kind={kind} main={at === 0} onFiles={onFiles} />
        ))}
      </div>
      <p class="muted drop-formats">{t.add.formats}</p>
    </div>
  );
}

interface PickerProps {
  readonly kind: "folder" | "files";
  /** Whether this is the usual choice. */
  readonly main: boolean;
  readonly onFiles: (files: File[]) => void;
}

/** A button that chooses a folder, or files for the many phones that cannot choose a folder. */
function Picker({ kind, main, onFiles }: PickerProps) {
  const text = kind === "folder" ? t.add.choose : t.add.chooseFiles;
  const input = useRef<HTMLInputElement>(null);
  return (
    <>
      <input
        ref={(element) => {
          input.current = element;
          if (element) element.webkitdirectory = kind === "folder"; // a property that is missing from the types of JSX
        }}
        type="file"
        class="visually-hidden"
        aria-label={text}
        multiple
        tabIndex={-1}
        onChange={(event) => {
          const files = [...(event.currentTarget.files ?? [])];
          event.currentTarget.value = ""; // the same files may be chosen again
          if (files.length > 0) onFiles(files);
        }}
      />
      <button type="button" class={`button${main ? " button-main" : ""}`} onClick={() => input.current?.click()}>
        {text}
      </button>
    </>
  );
}
