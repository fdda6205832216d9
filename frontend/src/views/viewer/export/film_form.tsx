import { useEffect, useRef } from "preact/hooks";
import { t } from "../../../texts";
import { Choice } from "../../choice";
import { Field } from "../../field";
import { fault as faulty } from "../../form";
import { filmQualities, filmRates, filmSideNames, filmSides, filmSize, typedSeconds } from "./film_size";
import { useFilmForm, type FilmEntries, type FilmFormProps } from "./use_film_form";
import { ViewList } from "./view_list";

/** The form for a turntable film or a tour. */
export function FilmForm(props: FilmFormProps) {
  const { session, kind, busy } = props;
  const text = t.take;
  const { entries, faults, preparing, set, correct, setFault, submit } = useFilmForm(props);
  const form = useRef<HTMLFormElement>(null);
  // A screen reader announces the error when its field has the focus, so the focus moves once the error is on the page.
  useEffect(() => {
    if (faults.seconds) form.current?.querySelector<HTMLElement>("[aria-invalid]")?.focus();
  }, [faults.seconds]);
  return (
    <form
      ref={form}
      class="take-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        void submit();
      }}
    >
      <p class="muted">{kind === "tour" ? text.tourLead : text.turntableLead}</p>
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
          options={filmRates.map((n) => [String(n), String(n)])}
          onChoose={(rate) => set({ rate })}
        />
      </div>
      <SizeAndQuality session={session} entries={entries} set={set} />
      <FaultOrHint fault={faults.form} entries={entries} />
      <p>
        <button type="submit" class="button button-main" disabled={busy || preparing}>
          {busy ? text.ofFilm.rendering : text.saveFilm}
        </button>
      </p>
    </form>
  );
}

interface SizeAndQualityProps extends Pick<FilmFormProps, "session"> {
  readonly entries: FilmEntries;
  readonly set: (part: Partial<FilmEntries>) => void;
}

function SizeAndQuality({ session, entries, set }: SizeAndQualityProps) {
  const text = t.take;
  return (
    <>
      <Choice
        label={text.size}
        value={entries.size}
        options={filmSideNames.map((name) => {
          const { width, height } = filmSize(session.viewport, filmSides[name]);
          return [name, text.filmSizes[name](width, height)];
        })}
        onChoose={(name) => set({ size: name as FilmEntries["size"] })}
      />
      <Choice
        label={text.quality}
        value={entries.quality}
        options={filmQualities.map((name) => [name, text.qualities[name]])}
        onChoose={(name) => set({ quality: name as FilmEntries["quality"] })}
      />
    </>
  );
}

function FaultOrHint({ fault, entries }: { readonly fault: string; readonly entries: FilmEntries }) {
  if (fault)
    return (
      <p class="field-fault" role="alert">
        {fault}
      </p>
    );
  return <p class="field-hint">{t.take.filmHint((typedSeconds(entries.seconds) ?? 0) * Number(entries.rate))}</p>;
}
