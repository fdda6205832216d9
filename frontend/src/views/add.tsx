import { useEffect, useRef, useState } from "preact/hooks";
import { dropped_files } from "../scan/picked_files";
import { scan_in_worker } from "../scan/scan_client";
import type { ScanResult } from "../scan/types";
import { t } from "../texts";
import { Icon } from "./icons";
import { SeriesList } from "./series_list";
import { Bar, Notice, PageTitle, use_focus_kept } from "./shell";

type Stage =
  | { readonly kind: "choose"; readonly fault?: string }
  | { readonly kind: "scanning"; readonly done: number; readonly total: number; readonly stop: () => void }
  | { readonly kind: "found"; readonly files: readonly File[]; readonly result: ScanResult };

export function Add() {
  const [stage, set_stage] = useState<Stage>({ kind: "choose" });
  const scanning = useRef<AbortController | null>(null);
  useEffect(() => () => scanning.current?.abort(), []);
  use_focus_kept(stage.kind);

  const scan = async (files: readonly File[]) => {
    const stopping = new AbortController();
    scanning.current = stopping;
    const stop = () => {
      stopping.abort();
      set_stage({ kind: "choose" });
    };
    set_stage({ kind: "scanning", done: 0, total: files.length, stop });
    try {
      const progress = (done: number, total: number) => {
        if (!stopping.signal.aborted) set_stage({ kind: "scanning", done, total, stop });
      };
      const result = await scan_in_worker(files, progress, stopping.signal);
      set_stage({ kind: "found", files, result });
    } catch {
      set_stage({ kind: "choose", fault: t.add.failed });
    }
  };

  return (
    <div class="page page-narrow">
      <PageTitle text={t.titles.add} />
      {stage.kind === "choose" ? (
        <>
          <p class="lead">{t.add.lead}</p>
          {stage.fault ? <Notice kind="bad">{stage.fault}</Notice> : null}
          <Drop onFiles={(files) => void scan(files)} />
          <Notice kind="info">{t.add.privacy}</Notice>
        </>
      ) : null}
      {stage.kind === "scanning" ? (
        <section class="scanning" role="status">
          <h2>{t.add.scanning}</h2>
          <Bar value={stage.total > 0 ? stage.done / stage.total : null} label={t.add.scanning} />
          <p class="muted">{t.add.scanned(stage.done, stage.total)}</p>
          <button type="button" class="button" onClick={stage.stop}>{t.add.stop}</button>
        </section>
      ) : null}
      {stage.kind === "found" ? (
        <SeriesList files={stage.files} result={stage.result} onAgain={() => set_stage({ kind: "choose" })} />
      ) : null}
    </div>
  );
}

function Drop({ onFiles }: { readonly onFiles: (files: File[]) => void }) {
  const [over, set_over] = useState(false);
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => {
    // Let go beside the field it counts too: the browser would leave the page and show the file.
    const allow = (event: DragEvent) => event.preventDefault();
    const take = (event: DragEvent) => {
      event.preventDefault();
      set_over(false);
      if (event.dataTransfer) void dropped_files(event.dataTransfer).then(onFiles);
    };
    addEventListener("dragover", allow);
    addEventListener("drop", take);
    return () => {
      removeEventListener("dragover", allow);
      removeEventListener("drop", take);
    };
  }, [onFiles]);
  return (
    <div
      class={`drop${over ? " drop-over" : ""}`}
      onDragOver={() => set_over(true)}
      onDragLeave={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node | null)) set_over(false);
      }}
    >
      <Icon name="folder" />
      <p class="drop-text" aria-hidden="true">{over ? t.add.dropping : t.add.drop}</p>
      <p class="muted" aria-hidden="true">{t.add.or}</p>
      <input
        ref={(element) => {
          input.current = element;
          if (element) element.webkitdirectory = true; // a property that the types of JSX do not have
        }}
        type="file"
        class="visually-hidden"
        aria-label={t.add.choose}
        multiple
        tabIndex={-1}
        onChange={(event) => {
          const files = [...(event.currentTarget.files ?? [])];
          event.currentTarget.value = ""; // the same folder may be chosen again
          if (files.length > 0) onFiles(files);
        }}
      />
      <button type="button" class="button button-main" onClick={() => input.current?.click()}>{t.add.choose}</button>
    </div>
  );
}
