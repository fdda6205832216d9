import type { Area } from "../../input/flat";
import { useRef, useState } from "preact/hooks";
import { boundsOf } from "../../cut/region";
import {
  cutHandles,
  drawnPlane,
  eyeOf,
  ballRadius,
  handleDragged,
  handleStepped,
  lightHandles,
  type Handle,
} from "../../picture/handles";
import { apart, onScreen, type Box } from "../../picture/project";
import type { Scene } from "../../protocol/gen/api/proto/scene_pb";
import { boxOf, planesOf } from "../../scene/cuts";
import { seenDirection } from "../../scene/lights";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { BoxLines, PlaneShape, Stroke } from "./box_lines";
import { HandleButton } from "./handle_button";
import type { HandleSet, InPicture } from "./in_picture";
import { useScreen } from "./use_screen";

export interface PictureHandlesProps {
  readonly session: ViewerSession;
  readonly picture: InPicture;
}

/** The box, the planes and the lights of the scene as handles over the picture. */
export function PictureHandles({ session, picture }: PictureHandlesProps) {
  const volume = session.volume.value,
    scene = session.editor.scene.value,
    shown = picture.shown.value;
  if (!volume || !scene || shown.length === 0) return null;
  return <Area session={session} picture={picture} scene={scene} bounds={boundsOf(volume)} shown={shown} />;
}

interface AreaProps extends PictureHandlesProps {
  readonly scene: Scene;
  readonly bounds: Box;
  readonly shown: readonly HandleSet[];
}

function Area({ session, picture, scene, bounds, shown }: AreaProps) {
  const area = useRef<HTMLDivElement>(null);
  const grabbed = useRef<Handle | null>(null);
  const [held, setHeld] = useState("");
  const screen = useScreen(area);
  const handlesOf = (of: Scene): Handle[] => [
    ...(shown.includes("cuts") ? cutHandles(of, bounds, screen) : []),
    ...(shown.includes("light") ? lightHandles(of, screen) : []),
  ];
  // A held handle stays on top, followed by the light that the window shows.
  const chosen = `light-${picture.light.value}`;
  const rank = (handle: Handle) => (handle.key === held ? -3 : handle.key === chosen ? -2 : handle.rank);
  const what = (handle: Handle) => `handle ${handle.key}`;
  const drag = (handle: Handle, to: { readonly x: number; readonly y: number }) =>
    session.editor.change(
      what(handle),
      (now) => {
        const fresh = handlesOf(now).find(({ key }) => key === handle.key);
        return fresh
          ? handleDragged(now, bounds, screen, { ...fresh, behind: grabbed.current?.behind ?? false }, to)
          : now;
      },
      true,
    );
  return (
    <div class="handle-area" ref={area} role="region" aria-label={t.settings.picture.area}>
      <svg aria-hidden="true" width={screen.width} height={screen.height}>
        {shown.includes("cuts") ? <CutLines scene={scene} bounds={bounds} screen={screen} /> : null}
        {shown.includes("light") ? <LightLines handles={lightHandles(scene, screen)} screen={screen} /> : null}
      </svg>
      {apart(handlesOf(scene), rank).map((handle) => (
        <HandleButton
          key={handle.key}
          name={handle.key}
          look={handle.of.kind}
          behind={handle.behind ?? false}
          at={handle}
          low={handle.low}
          high={handle.high}
          now={handle.now}
          label={labelOf(scene, handle)}
          valueText={valueTextOf(scene, handle)}
          grab={() => {
            grabbed.current = handle;
            if (handle.of.kind === "light") picture.light.value = handle.of.index;
          }}
          drag={(to) => drag(handle, to)}
          step={(right, up) =>
            session.editor.change(what(handle), (now) => handleStepped(now, bounds, handle, right, up))
          }
          rest={() => session.editor.rest()}
          hold={(on) => setHeld((before) => (on ? handle.key : before === handle.key ? "" : before))}
        />
      ))}
    </div>
  );
}

interface LinesProps {
  readonly scene: Scene;
  readonly bounds: Box;
  readonly screen: Area;
}

function CutLines({ scene, bounds, screen }: LinesProps) {
  const eye = eyeOf(scene);
  if (!eye) return null;
  const view = { eye, screen };
  return (
    <g>
      <BoxLines {...view} box={boxOf(scene, bounds)} />
      {planesOf(scene).map((_, index) => {
        const drawn = drawnPlane(scene, bounds, index);
        if (!drawn) return null;
        return (
          <g key={index}>
            <PlaneShape {...view} polygon={drawn.polygon} />
            <Stroke
              from={onScreen(eye, screen, drawn.base)}
              to={onScreen(eye, screen, drawn.tip)}
              name="handle-normal"
            />
          </g>
        );
      })}
    </g>
  );
}

function LightLines({ handles, screen }: { readonly handles: readonly Handle[]; readonly screen: Area }) {
  const x = screen.width / 2,
    y = screen.height / 2;
  return (
    <g>
      <circle class="handle-ball" cx={x} cy={y} r={ballRadius(screen)} />
      {handles.map((handle) => (
        <line
          key={handle.key}
          class="handle-ray"
          x1={handle.x}
          y1={handle.y}
          x2={x + 0.55 * (handle.x - x)}
          y2={y + 0.55 * (handle.y - y)}
        />
      ))}
    </g>
  );
}

function labelOf(scene: Scene, { of }: Handle): string {
  const text = t.settings;
  switch (of.kind) {
    case "face":
      return text.cuts.faces[of.axis][of.side];
    case "plane":
      return text.cuts.plane(of.index + 1);
    case "tilt":
      return text.picture.tilt(text.cuts.plane(of.index + 1));
    case "light":
      return text.light.light(scene.lights[of.index]?.name ?? "", of.index + 1);
  }
}

function valueTextOf(scene: Scene, { of, now }: Handle): string {
  const text = t.settings.picture;
  if (of.kind === "tilt") {
    const plane = planesOf(scene)[of.index];
    return text.towards((plane?.right ?? 0).toFixed(0), (plane?.up ?? 0).toFixed(0));
  }
  if (of.kind === "light") {
    const eye = eyeOf(scene),
      light = scene.lights[of.index];
    const direction = eye && light && seenDirection(light, eye);
    return text.towards((direction?.right ?? 0).toFixed(0), (direction?.up ?? 0).toFixed(0));
  }
  return text.mm(now.toFixed(0));
}
