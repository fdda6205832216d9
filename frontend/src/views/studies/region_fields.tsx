import { cameraOf } from "../../protocol/messages";
import { add, length, scale, subtract, vec3, type Vec3 } from "../../input/vec3";
import { limits } from "../../studies/check";
import type { Numbers, Region } from "../../studies/definition";
import { numbersOf } from "../../studies/views";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import type { InPicture } from "../picture/in_picture";
import { NumberControl, Switch } from "../viewer/settings/controls";
import { TextFields } from "./text_fields";
import type { ViewSettings } from "./view_settings";

export interface RegionFieldsProps {
  readonly session: ViewerSession;
  readonly picture: InPicture;
  readonly settings: ViewSettings;
  readonly set: (settings: ViewSettings) => void;
}

const radiusLimits = { low: 1, high: 500 };
const placeLimits = { low: -5000, high: 5000 };
const axes = ["x", "y", "z"] as const;

/** The highlighted part: marked in the picture, or typed. */
export function RegionFields({ session, picture, settings, set }: RegionFieldsProps) {
  const text = t.studies.editor;
  const { region } = settings;
  const change = (next: Region) => set({ ...settings, region: next });
  const mark = () => {
    picture.picking.value = {
      label: text.markLabel,
      pick: async ({ x, y }) => {
        const found = await session.depthAt(x, y);
        if (!found.answered || !found.seen) return text.nothingThere;
        change({ ...(region ?? firstRegion(session)), centre: numbersOf(rounded(found.seen.place)) });
        return null;
      },
    };
  };
  return (
    <section class="study-region">
      <Switch
        label={text.region}
        on={region !== null}
        change={(on) => set({ ...settings, region: on ? firstRegion(session) : null })}
      />
      <p class="field-hint">{text.regionHint}</p>
      {region ? (
        <>
          <p>
            <button type="button" class="button" onClick={mark}>
              {text.mark}
            </button>
          </p>
          <RegionNumbers session={session} region={region} change={change} />
        </>
      ) : null}
    </section>
  );
}

interface RegionNumbersProps {
  readonly session: ViewerSession;
  readonly region: Region;
  readonly change: (region: Region) => void;
}

function RegionNumbers({ session, region, change }: RegionNumbersProps) {
  const text = t.studies.editor;
  return (
    <>
      <TextFields
        label={text.regionName}
        value={region.name}
        most={limits.title}
        change={(name) => change({ ...region, name })}
      />
      <NumberControl
        label={text.radius}
        unit={text.mm}
        value={region.radius}
        limits={radiusLimits}
        slide={{ low: 1, high: 150 }}
        rest={() => session.editor.rest()}
        change={(radius) => change({ ...region, radius })}
      />
      {axes.map((axis, i) => (
        <NumberControl
          key={axis}
          label={text.centre[axis]}
          unit={text.mm}
          value={region.centre[i] ?? 0}
          limits={placeLimits}
          slide={{ low: -300, high: 300 }}
          rest={() => session.editor.rest()}
          change={(value) => change({ ...region, centre: withNumber(region.centre, i, value) })}
        />
      ))}
    </>
  );
}

const withNumber = (of: Numbers, index: number, value: number): Numbers =>
  of.map((one, i) => (i === index ? value : one)) as unknown as Numbers;

/** Returns a place in tenths of a millimetre, which are finer than any voxel. */
const rounded = ({ x, y, z }: Vec3): Vec3 =>
  vec3(Math.round(10 * x) / 10, Math.round(10 * y) / 10, Math.round(10 * z) / 10);

/** Returns a region on the near side of the camera's target. */
function firstRegion(session: ViewerSession): Region {
  const scene = session.editor.scene.value;
  const pose = scene && cameraOf(scene);
  if (!pose) return { name: {}, centre: [0, 0, 0], radius: 30 };
  const away = subtract(pose.eye, pose.target);
  const far = length(away);
  const centre = rounded(add(pose.target, scale(away, 0.08)));
  return { name: {}, centre: numbersOf(centre), radius: Math.max(5, Math.round(far * 0.05)) };
}
