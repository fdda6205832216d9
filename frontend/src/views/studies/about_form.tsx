import { limits } from "../../studies/check";
import type { Definition } from "../../studies/definition";
import { t } from "../../texts";
import { Field } from "../field";
import { Switch } from "../viewer/settings/controls";
import { TextFields } from "./text_fields";

export interface AboutFormProps {
  readonly definition: Definition;
  readonly change: (definition: Definition) => void;
}

/** Returns the local day of a time as the browser's date field has it, or empty. */
function dayOf(time: string): string {
  const date = new Date(time);
  if (Number.isNaN(date.getTime())) return "";
  const two = (value: number) => String(value).padStart(2, "0");
  return `${date.getFullYear()}-${two(date.getMonth() + 1)}-${two(date.getDate())}`;
}

/** Returns the end of a local day as RFC 3339, or an empty text if there is no such day. */
function endOf(day: string): string {
  const date = new Date(`${day}T23:59:59`);
  return Number.isNaN(date.getTime()) ? "" : date.toISOString();
}

/** The title, the places and the end of a study. */
export function AboutForm({ definition, change }: AboutFormProps) {
  const text = t.studies;
  return (
    <section class="share-part study-about">
      <h2>{text.about}</h2>
      <TextFields
        label={text.studyTitle}
        value={definition.title}
        most={limits.title}
        change={(title) => change({ ...definition, title })}
      />
      <div class="study-texts">
        <Field
          label={text.places}
          value={Number.isNaN(definition.places) ? "" : String(definition.places)}
          digits
          hint={text.placesHint}
          onInput={(value) => change({ ...definition, places: value.trim() === "" ? 0 : Number(value) })}
        />
        <Field
          label={text.ends}
          type="date"
          value={dayOf(definition.ends_at)}
          hint={text.endsHint}
          onInput={(day) => change({ ...definition, ends_at: endOf(day) })}
        />
      </div>
      <Switch label={text.record} on={definition.record} change={(record) => change({ ...definition, record })} />
      <p class="field-hint">{text.recordHint}</p>
    </section>
  );
}
