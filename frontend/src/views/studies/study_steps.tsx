import { useEffect, useRef, useState } from "preact/hooks";
import { hasView, textIn, type Answer, type Step } from "../../studies/definition";
import type { Ending, Participation } from "../../studies/participation";
import { patiently } from "../../studies/patiently";
import { language, t } from "../../texts";
import { Dialog } from "../dialog";
import { Notice, PageTitle } from "../shell";
import { useAct } from "../use_act";
import { StepPage } from "./step_page";
import { StudyFrame, StudyMessage } from "./study_frame";

export interface StudyStepsProps {
  readonly participation: Participation;
  readonly end: (ending: Ending) => void;
  /** Set in a preview, which is left in place of being stopped. */
  readonly leave?: () => void;
}

/** Leads a participant through the steps. There is no way back to an answered step. */
export function StudySteps({ participation, end, leave }: StudyStepsProps) {
  const [stopping, setStopping] = useState(false);
  const { queue, joined } = participation;
  useQueue(participation, end);
  const step = participation.current();
  const title = textIn(joined.definition.title, language.value);
  const tools = (
    <button type="button" class="button button-small" onClick={() => (leave ? leave() : setStopping(true))}>
      {leave ? t.takePart.previewEnd : t.takePart.stop}
    </button>
  );
  const dialog = stopping ? (
    <StopDialog participation={participation} onClose={() => setStopping(false)} end={end} />
  ) : null;
  if (!step)
    return (
      <StudyMessage>
        <PageTitle text={title.text} />
        <QueueNotices queue={queue} />
        <p role="status">{t.takePart.finishing}</p>
      </StudyMessage>
    );
  const answer = (value: Answer, durationMs: number) => participation.answer(step, value, durationMs);
  return (
    <StudyFrame filled={hasView(step) && step.view !== undefined} tools={tools}>
      <Progress participation={participation} title={title} step={step} />
      {leave ? <Notice kind="info">{t.takePart.preview}</Notice> : null}
      <QueueNotices queue={queue} />
      <StepPage key={step.id} step={step} participation={participation} answer={answer} />
      {dialog}
    </StudyFrame>
  );
}

/** Sends what is pending, also when the network is back, and ends the participation after the last step. */
function useQueue(participation: Participation, end: (ending: Ending) => void): void {
  const { queue } = participation;
  const isLast = participation.current() === null;
  const over = queue.over.value;
  useEffect(() => {
    const wake = () => queue.wake();
    wake();
    addEventListener("online", wake);
    return () => {
      removeEventListener("online", wake);
      // After a change of the language, a new queue continues with the same store.
      queue.stop();
    };
  }, [queue]);
  useEffect(() => {
    if (over !== null) end(over);
    // eslint-disable-next-line react-hooks/exhaustive-deps -- `end` is new in each render
  }, [over]);
  useEffect(() => {
    if (!isLast) return;
    return patiently(() => participation.finish(), {
      done: () => {
        if (queue.over.value === null) end("finished");
      },
      refused: (thrown) => {
        if (!participation.endIfOver(thrown)) end("finished");
      },
      waiting: () => (queue.waiting.value = true),
    });
    // eslint-disable-next-line react-hooks/exhaustive-deps -- `end` is new in each render
  }, [isLast, participation]);
}

interface ProgressProps {
  readonly participation: Participation;
  readonly title: { readonly text: string; readonly lang: string };
  readonly step: Step;
}

function Progress({ participation, title, step }: ProgressProps) {
  const all = participation.steps.length;
  const at = participation.steps.indexOf(step) + 1;
  const text = t.takePart.progress(at, all);
  const place = useRef<HTMLParagraphElement>(null);
  const first = useRef(step.id);
  useEffect(() => {
    if (step.id === first.current) return;
    first.current = "";
    scrollTo(0, 0);
    place.current?.focus({ preventScroll: true });
  }, [step.id]);
  return (
    <div class="study-progress">
      <div lang={title.lang}>
        <PageTitle text={title.text} first={participation.answered() === 0} />
      </div>
      <p ref={place} tabIndex={-1} role="status">
        {text}
      </p>
      <progress aria-label={text} max={all} value={participation.answered()} />
    </div>
  );
}

function QueueNotices({ queue }: { readonly queue: Participation["queue"] }) {
  return (
    <>
      {queue.waiting.value ? <Notice kind="info">{t.takePart.waiting}</Notice> : null}
      {queue.refused.value.length > 0 ? <Notice kind="warn">{t.takePart.refused}</Notice> : null}
    </>
  );
}

interface StopDialogProps {
  readonly participation: Participation;
  readonly onClose: () => void;
  readonly end: (ending: Ending) => void;
}

/** Asks whether the answers so far are kept. */
function StopDialog({ participation, onClose, end }: StopDialogProps) {
  const keeping = useAct();
  const deleting = useAct();
  /** What was chosen last. Null once the dialog is closed, so that a late network does not stop the participant. */
  const chosen = useRef<"kept" | "deleted" | null>(null);
  const isChosen = (ending: "kept" | "deleted"): boolean => chosen.current === ending;
  useEffect(() => () => void (chosen.current = null), []);
  const text = t.takePart;
  const { queue } = participation;
  const keep = () =>
    keeping.act(async () => {
      chosen.current = "kept";
      await queue.whenEmpty();
      if (isChosen("kept") && queue.over.value === null) end("kept");
      return "";
    });
  const remove = () =>
    deleting.act(async () => {
      chosen.current = "deleted";
      await participation.withdraw();
      end("deleted");
      return "";
    });
  return (
    <Dialog title={text.stopTitle} onClose={onClose}>
      <p>{text.stopText}</p>
      <div class="study-choices">
        <button type="button" class="button button-main" disabled={keeping.busy || deleting.busy} onClick={keep}>
          {text.stopKeep}
        </button>
        <button type="button" class="button button-danger" disabled={deleting.busy} onClick={remove}>
          {text.stopDelete}
        </button>
        <button type="button" class="button" onClick={onClose}>
          {text.stopNot}
        </button>
      </div>
      <QueueNotices queue={queue} />
      {keeping.outcome}
      {deleting.outcome}
    </Dialog>
  );
}
