import { sceneFromJson, sceneToJson, type Scene } from "../../protocol/messages";
import { hexOf } from "../../scene/colour";
import { channelsOf } from "../../scene/transfer";
import { limits } from "../../studies/check";
import type { ColoursStep, Material, Step } from "../../studies/definition";
import { firstMaterial, referenceColours, shownMaterials, withMaterialColour } from "../../studies/materials";
import { t } from "../../texts";
import { ColourControl, Switch } from "../viewer/settings/controls";
import { TextFields } from "./text_fields";

export interface MaterialFieldsProps {
  readonly step: ColoursStep;
  readonly change: (step: Step) => void;
}

/** The materials of a step's picture, with the names and first colours that participants get. */
export function MaterialFields({ step, change }: MaterialFieldsProps) {
  const text = t.studies;
  const { view, materials } = step;
  const scene = view ? sceneFromJson(JSON.stringify(view.scene)) : null;
  if (!view || !scene) return <p class="muted">{text.materialsNone}</p>;
  const names = shownMaterials(scene);
  const setScene = (next: Scene) =>
    change({ ...step, view: { ...view, scene: JSON.parse(sceneToJson(next)) as object } });
  const setMaterial = (name: string, material: Material | null) => {
    const all = [...materials.filter(({ channel }) => channel !== name), ...(material ? [material] : [])];
    change({ ...step, materials: names.flatMap((one) => all.find(({ channel }) => channel === one) ?? []) });
  };
  const referenced = names.filter((name) => referenceColours[name] !== undefined);
  return (
    <fieldset class="study-materials">
      <legend>{text.materials}</legend>
      {names.map((name, i) => (
        <MaterialRow
          key={name}
          name={name}
          shown={t.settings.look.channel(name, i + 1)}
          scene={scene}
          material={materials.find(({ channel }) => channel === name) ?? null}
          full={materials.length >= limits.materials}
          setColour={(hex) => setScene(withMaterialColour(scene, name, hex))}
          setMaterial={(material) => setMaterial(name, material)}
        />
      ))}
      {referenced.length > 0 ? (
        <p>
          <button
            type="button"
            class="button button-small"
            onClick={() =>
              setScene(
                referenced.reduce((now, name) => withMaterialColour(now, name, referenceColours[name] ?? ""), scene),
              )
            }
          >
            {text.referenceColours}
          </button>
        </p>
      ) : null}
    </fieldset>
  );
}

interface MaterialRowProps {
  readonly name: string;
  /** The name in the language of the page. */
  readonly shown: string;
  readonly scene: Scene;
  readonly material: Material | null;
  readonly full: boolean;
  readonly setColour: (hex: string) => void;
  readonly setMaterial: (material: Material | null) => void;
}

function MaterialRow({ name, shown, scene, material, full, setColour, setMaterial }: MaterialRowProps) {
  const text = t.studies;
  return (
    <div class="study-material">
      <Switch
        label={text.material(shown)}
        on={material !== null}
        disabled={full && material === null}
        change={(on) => setMaterial(on ? firstMaterial(name) : null)}
      />
      {material ? (
        <>
          <ColourControl
            label={text.materialColour(shown)}
            value={channelsOf(scene).find((one) => one.name === name)?.diffuse}
            rest={() => undefined}
            change={(colour) => setColour(hexOf(colour))}
          />
          <TextFields
            label={text.materialName(shown)}
            value={material.name}
            most={limits.title}
            change={(words) => setMaterial({ channel: name, name: words })}
          />
        </>
      ) : null}
    </div>
  );
}
