import { useEffect, useRef } from "preact/hooks";
import { t } from "../../../texts";
import { Choice } from "../../choice";
import { Field } from "../../field";
import { DrawMarks } from "../../marks/draw_marks";
import { fault as faulty } from "../../form";
import {
  renderingSeconds,
  videoErrors,
  videoQualities,
  videoRates,
  videoSideNames,
  videoSides,
  videoSize,
  typedSeconds,
} from "./video_size";
import { useVideoForm, type VideoEntries, type VideoFormProps } from "./use_video_form";
import { ViewList } from "./view_list";
import { TakeForm } from "./take_form";

/** The form for a turntable video or a tour. */
export function VideoForm(props: VideoFormProps) {
  const { session, kind, busy } = props;
  const text = t.take;
  const { entries, faults, preparing, set, correct, setFault, submit } = useVideoForm(props);
  const form = useRef<HTMLFormElement>(null);
  // A screen reader announces the error when its field has the focus, so the focus moves once the error is on the page.
  useEffect(() => {
    if (faults.seconds || faults.cycles) form.current?.querySelector<HTMLElement>("[aria-invalid]")?.focus();
  }, [faults.seconds, faults.cycles]);
  return (
    <TakeForm form={form} onSubmit={() => void submit()}>
      <p class="muted">{text[`${kind}Lead`]}</p>
      {kind === "tour" && session.dataSetId !== null ? (
        <ViewList
          dataSetId={session.dataSetId}
          views={entries.views}
          onViews={(views) => correct({ views })}
          onFault={setFault}
        />
      ) : null}
      <div class="take-sides">
        <Field
          label={text.seconds}
          value={entries.seconds}
          onInput={(seconds) => correct({ seconds })}
          digits
          most={3}
          {...faulty(faults.seconds)}
        />
        <Choice
          label={text.rate}
          value={entries.rate}
          options={videoRates.map((n) => [String(n), String(n)])}
          onChoose={(rate) => set({ rate })}
        />
      </div>
      {session.phases.phases.value.length > 1 ? (
        <Field
          label={t.phases.cycles}
          value={entries.cycles}
          onInput={(cycles) => correct({ cycles })}
          digits
          most={4}
          {...(kind === "phases" ? {} : { hint: t.phases.cyclesHint })}
          {...faulty(faults.cycles)}
        />
      ) : null}
      <SizeAndQuality session={session} entries={entries} set={set} />
      <DrawMarks video session={session} on={entries.withMarks} change={(withMarks) => set({ withMarks })} />
      <FaultOrHint fault={faults.form} entries={entries} session={session} />
      <p>
        <button type="submit" class="button button-main" disabled={busy || preparing}>
          {busy ? text.ofVideo.rendering : text.saveVideo}
        </button>
      </p>
    </TakeForm>
  );
}

interface SizeAndQualityProps extends Pick<VideoFormProps, "session"> {
  readonly entries: VideoEntries;
  readonly set: (part: Partial<VideoEntries>) => void;
}

function SizeAndQuality({ session, entries, set }: SizeAndQualityProps) {
  const text = t.take;
  return (
    <>
      <Choice
        label={text.size}
        value={entries.size}
        options={videoSideNames.map((name) => {
          const { width, height } = videoSize(session.viewport, videoSides[name]);
          return [name, text.videoSizes[name](width, height)];
        })}
        onChoose={(name) => set({ size: name as VideoEntries["size"] })}
      />
      <Choice
        label={text.quality}
        value={entries.quality}
        options={videoQualities.map((name) => [name, text.qualities[name]])}
        onChoose={(name) => set({ quality: name as VideoEntries["quality"] })}
      />
    </>
  );
}

interface FaultOrHintProps extends Pick<VideoFormProps, "session"> {
  readonly fault: string;
  readonly entries: VideoEntries;
}

function FaultOrHint({ fault, entries, session }: FaultOrHintProps) {
  const shown = session.pictures.picture.value;
  if (fault)
    return (
      <p class="field-fault" role="alert">
        {fault}
      </p>
    );
  const frames = (typedSeconds(entries.seconds) ?? 0) * Number(entries.rate);
  const size = videoSize(session.viewport, videoSides[entries.size]);
  const device = session.device.value;
  const time = shown && renderingSeconds(shown, frames, size, videoErrors[entries.quality], device);
  return (
    <>
      <p class="field-hint">{t.take.videoHint(frames)}</p>
      {frames > 0 ? <p>{t.take.videoTime(time)}</p> : null}
    </>
  );
}
