import type { Alignment } from "../../api/alignments";
import { t } from "../../texts";
import { Notice } from "../shell";
import { isAligning, type AlignmentTask } from "./use_alignment";

/** Says whether two scans are aligned, and how well, and aligns them. */
export function AlignPanel({ task }: { readonly task: AlignmentTask }) {
  const { found, fault, busy } = task;
  const text = t.compare.align;
  return (
    <div class="align-panel">
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      <div role="status">{found ? <AlignmentState found={found} /> : null}</div>
      {found?.state === "ready" && !found.frame_of_reference_shared ? (
        <p class="muted">
          <small>{text.notMedical}</small>
        </p>
      ) : null}
      {found && !found.frame_of_reference_shared ? (
        found.may_align ? (
          <div class="dialog-buttons">
            <AlignButtons task={task} found={found} busy={busy} />
          </div>
        ) : found.state === "none" ? (
          <p class="muted">{text.notYours}</p>
        ) : null
      ) : null}
    </div>
  );
}

function AlignmentState({ found }: { readonly found: Alignment }) {
  const text = t.compare.align;
  if (found.frame_of_reference_shared) return <p>{text.shared}</p>;
  switch (found.state) {
    case "none":
      return (
        <>
          <p>{text.needed}</p>
          <p class="muted">{text.duration}</p>
        </>
      );
    case "waiting":
    case "running":
      return (
        <>
          <p>{text[found.state]}</p>
          <progress aria-label={text[found.state]} />
          <p class="muted">{text.leave}</p>
        </>
      );
    case "ready":
      return (
        <p>
          {text.ready(found.residual_mm ?? 0)} {found.overlap === null ? "" : text.overlap(found.overlap)}
        </p>
      );
    case "failed":
      return (
        <p class="card-fault">
          {text.failed} {text.reasons[found.reason ?? ""] ?? ""}
        </p>
      );
  }
}

function AlignButtons({ task, found, busy }: { task: AlignmentTask; found: Alignment; busy: boolean }) {
  const text = t.compare.align;
  if (found.state === "none")
    return (
      <button type="button" class="button button-main" disabled={busy} onClick={task.request}>
        {text.start}
      </button>
    );
  return (
    <>
      <button type="button" class="button" disabled={busy} onClick={task.remove}>
        {isAligning(found) ? t.cancel : text.remove}
      </button>
      {isAligning(found) ? null : (
        <button type="button" class="button" disabled={busy} onClick={task.again}>
          {text.again}
        </button>
      )}
    </>
  );
}
