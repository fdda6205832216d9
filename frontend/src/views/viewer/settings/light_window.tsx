import { useState } from "preact/hooks";
import { boundsOf } from "../../../cut/region";
import type { Light } from "../../../protocol/gen/api/proto/scene_pb";
import { hueOf } from "../../../scene/colour";
import { reachOf } from "../../../scene/cuts";
import * as lights from "../../../scene/lights";
import { t } from "../../../texts";
import { KeepHandles, type PictureWindowProps } from "./controls";
import { ListChip } from "./list_chip";
import { OneLight } from "./one_light";
import { sceneEdits } from "./scene_edits";

const kinds = ["rectangle", "disk", "sphere", "box", "environment"] as const;
type LightKind = (typeof kinds)[number];

/** The list of lights, and the properties of the chosen one. */
export function LightWindow({ session, leads, picture }: PictureWindowProps) {
  const text = t.settings.light;
  const scene = session.editor.scene.value;
  const volume = session.volume.value;
  if (!scene) return null;
  const index = Math.min(picture.light.value, scene.lights.length - 1);
  const choose = (which: number) => (picture.light.value = which);
  const light = scene.lights[index];
  const { apply } = sceneEdits(session.editor);
  const add = (shape: LightKind) => {
    const radius = volume ? reachOf(boundsOf(volume)) : 200;
    apply("light added", (now) => lights.addLight(now, shape, text.kinds[shape], radius));
    choose(scene.lights.length);
  };
  return (
    <>
      <LightList
        all={scene.lights}
        chosen={index}
        choose={choose}
        turn={(i, on) => apply(`light on ${i}`, (now) => lights.switchLight(now, i, !on))}
      />
      <KeepHandles picture={picture} which="light" />
      {light ? (
        <OneLight session={session} leads={leads} picture={picture} light={light} index={index} />
      ) : (
        <p class="hint">{text.none}</p>
      )}
      <AddLight full={scene.lights.length >= lights.mostLights} add={add} />
    </>
  );
}

interface LightListProps {
  readonly all: readonly Light[];
  readonly chosen: number;
  readonly choose: (index: number) => void;
  /** Turns a light on or off. */
  readonly turn: (index: number, on: boolean) => void;
}

function LightList({ all, chosen, choose, turn }: LightListProps) {
  const text = t.settings.light;
  return (
    <div class="channels" role="group" aria-label={text.lights}>
      {all.map((one, i) => {
        const name = text.light(one.name, i + 1);
        return (
          <span key={i} class="channel" data-light={i}>
            <ListChip
              name={name}
              colour={hueOf(lights.radianceOf(one))}
              chosen={i === chosen}
              choose={() => choose(i)}
              on={!one.disabled}
              turn={(on) => turn(i, on)}
              turnLabel={text.on(name)}
            />
          </span>
        );
      })}
    </div>
  );
}

/**
 * A list of kinds. It goes back to its empty entry, so that the same kind can be added again. With as many lights as a
 * scene can have, it says so instead.
 */
function AddLight({ full, add }: { readonly full: boolean; readonly add: (kind: LightKind) => void }) {
  const text = t.settings.light;
  const [refused, setRefused] = useState(false);
  return (
    <label class="control">
      <span class="control-name">{text.add}</span>
      <select
        class="choice"
        value=""
        onChange={(event) => {
          const chosen = kinds.find((one) => one === event.currentTarget.value);
          if (chosen && !full) add(chosen);
          setRefused(chosen !== undefined && full);
          event.currentTarget.value = "";
        }}
      >
        <option value="">…</option>
        {kinds.map((kind) => (
          <option key={kind} value={kind}>
            {text.kinds[kind]}
          </option>
        ))}
      </select>
      {refused && full ? (
        <span class="field-fault" role="alert">
          {text.tooMany(lights.mostLights)}
        </span>
      ) : null}
    </label>
  );
}
