import { useRef } from "preact/hooks";
import type { DataSet } from "../../api/types";
import { t } from "../../texts";
import { labelRefusalText } from "../../texts/refusal";
import { Dialog } from "../dialog";
import { bytesText } from "../format";
import { titleOf } from "../scan_card";
import { Bar, Notice } from "../shell";
import { useLabels, type LabelsTask } from "./use_labels";

export interface LabelsDialogProps {
  readonly set: DataSet;
  readonly onClose: () => void;
}

/**
 * Adds, replaces and removes the labels of a scan. An upload pauses when the dialog is closed, and resumes if the same
 * file is chosen again.
 */
export function LabelsDialog({ set, onClose }: LabelsDialogProps) {
  const task = useLabels(set);
  const input = useRef<HTMLInputElement>(null);
  const { labels, phase, fault, again } = task;
  const busy = phase !== null;
  return (
    <Dialog title={t.labels.title(titleOf(set))} onClose={onClose}>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {!fault && !busy && labels?.refusal ? <Notice kind="bad">{labelRefusalText(labels.refusal)}</Notice> : null}
      <State task={task} />
      <p>{t.labels.explain}</p>
      <p class="hint">{t.labels.privacy}</p>
      <input
        ref={input}
        type="file"
        class="visually-hidden"
        tabIndex={-1}
        aria-label={t.labels.choose}
        data-testid="label-file"
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          event.currentTarget.value = "";
          if (file) void task.add(file);
        }}
      />
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {busy ? t.cancel : t.close}
        </button>
        {labels && labels.count > 0 ? (
          <button type="button" class="button button-danger" disabled={busy} onClick={() => void task.remove()}>
            {t.labels.remove}
          </button>
        ) : null}
        {again ? (
          <button type="button" class="button" onClick={() => void again()}>
            {t.tryAgain}
          </button>
        ) : null}
        <button type="button" class="button button-main" disabled={busy} onClick={() => input.current?.click()}>
          {labels && labels.count > 0 ? t.labels.replace : t.labels.choose}
        </button>
      </div>
    </Dialog>
  );
}

function State({ task: { labels, phase, sent, stalled } }: { readonly task: LabelsTask }) {
  if (phase !== null)
    return (
      <>
        <Bar value={phase === "sending" ? sent : null} label={t.labels.phases[phase]} />
        <p role="status">
          {phase !== "sending"
            ? t.labels.phases[phase]
            : stalled
              ? t.scans.upload.stalled[stalled]
              : t.labels.sending(sent)}
        </p>
      </>
    );
  if (!labels || labels.count === 0) return <p role="status">{t.labels.none}</p>;
  return <p role="status">{t.labels.has(labels.count, bytesText(labels.bytes))}</p>;
}
