import { useId } from "preact/hooks";
import { studyLanguages, withText, type StudyLanguage, type Text } from "../../studies/definition";
import { t } from "../../texts";

export interface TextFieldsProps {
  readonly label: string;
  readonly value: Text;
  readonly most: number;
  /** Whether the text may have paragraphs. */
  readonly long?: boolean;
  readonly change: (value: Text) => void;
}

/** A text for participants in both languages, side by side. */
export function TextFields({ label, value, most, long = false, change }: TextFieldsProps) {
  const id = useId();
  const names: Readonly<Record<StudyLanguage, string>> = { en: t.studies.english, de: t.studies.german };
  return (
    <div class="study-texts" role="group" aria-label={label}>
      {studyLanguages.map((language) => {
        const common = {
          id: `${id}-${language}`,
          lang: language,
          maxLength: most,
          value: value[language] ?? "",
          onInput: (event: { readonly currentTarget: { readonly value: string } }) =>
            change(withText(value, language, event.currentTarget.value)),
        };
        return (
          <div class="field" key={language}>
            <label for={common.id}>
              {label} <span class="muted">({names[language]})</span>
            </label>
            {long ? <textarea class="prose" rows={4} {...common} /> : <input type="text" class="choice" {...common} />}
          </div>
        );
      })}
    </div>
  );
}
