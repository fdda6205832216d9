import { mayChangeParts, type StepKind, type View } from "../../studies/definition";
import { t } from "../../texts";
import { Choice } from "../choice";
import { Switch } from "../viewer/settings/controls";
import type { ViewSettings } from "./view_settings";

export interface MayChangeFieldsProps {
  readonly kind: StepKind;
  readonly settings: ViewSettings;
  readonly set: (settings: ViewSettings) => void;
}

/** What participants may change in the picture, and how they see it first. */
export function MayChangeFields({ kind, settings, set }: MayChangeFieldsProps) {
  const text = t.studies.editor;
  const starts: readonly View["start"][] = ["preset", "random"];
  return (
    <>
      <fieldset class="study-may">
        <legend>{text.mayChange}</legend>
        {mayChangeParts.map((part) => (
          <Switch
            key={part}
            label={text.may[part]}
            on={settings.mayChange.includes(part)}
            change={(on) =>
              set({
                ...settings,
                mayChange: mayChangeParts.filter((one) => (one === part ? on : settings.mayChange.includes(one))),
              })
            }
          />
        ))}
      </fieldset>
      {kind === "latency" ? null : ( // its trials always begin with random views
        <Choice
          label={text.start}
          value={settings.start}
          options={starts.map((one) => [one, text.starts[one]] as const)}
          onChoose={(value) => set({ ...settings, start: value === "random" ? "random" : "preset" })}
        />
      )}
    </>
  );
}
