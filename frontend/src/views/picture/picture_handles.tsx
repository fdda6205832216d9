import type { Area } from "../../input/flat";
import { useRef, useState } from "preact/hooks";
import { bounds_of } from "../../cut/region";
import { cut_handles, drawn_plane, eye_of, ball_radius, handle_dragged, handle_stepped, light_handles, type Handle } from "../../picture/handles";
import { apart, on_screen, type Box } from "../../picture/project";
import type { Scene } from "../../protocol/gen/api/proto/scene_pb";
import { box_of, planes_of } from "../../scene/cuts";
import { seen_direction } from "../../scene/lights";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";
import { BoxLines, PlaneShape, Stroke } from "./box_lines";
import { HandleButton } from "./handle_button";
import type { HandleSet, InPicture } from "./in_picture";
import { use_screen } from "./use_screen";

export interface PictureHandlesProps {
  readonly session: ViewerSession;
  readonly picture: InPicture;
}

/** Over the picture: the box, planes and lights of the scene, to be taken hold of. */
export function PictureHandles({ session, picture }: PictureHandlesProps) {
  const volume = session.volume.value, scene = session.scene.value, shown = picture.shown.value;
  if (!volume || !scene || shown.length === 0) return null;
  return <Area session={session} picture={picture} scene={scene} bounds={bounds_of(volume)} shown={shown} />;
}

interface AreaProps extends PictureHandlesProps {
  readonly scene: Scene;
  readonly bounds: Box;
  readonly shown: readonly HandleSet[];
}

function Area({ session, picture, scene, bounds, shown }: AreaProps) {
  const area = useRef<HTMLDivElement>(null);
  const grabbed = useRef<Handle | null>(null);
  const [held, set_held] = useState("");
  const screen = use_screen(area);
  const handles_of = (of: Scene): Handle[] => [
    ...(shown.includes("cuts") ? cut_handles(of, bounds, screen) : []),
    ...(shown.includes("light") ? light_handles(of, screen) : []),
  ];
  // What is held stays, then the light that the window shows.
  const chosen = `light-${picture.light.value}`;
  const rank = (handle: Handle) => (handle.key === held ? -3 : handle.key === chosen ? -2 : handle.rank);
  const what = (handle: Handle) => `handle ${handle.key}`;
  const drag = (handle: Handle, to: { readonly x: number; readonly y: number }) =>
    session.change(what(handle), (now) => {
      const fresh = handles_of(now).find(({ key }) => key === handle.key);
      return fresh ? handle_dragged(now, bounds, screen, { ...fresh, behind: grabbed.current?.behind ?? false }, to) : now;
    }, true);
  return (
    <div class="handle-area" ref={area} role="region" aria-label={t.settings.picture.area}>
      <svg aria-hidden="true" width={screen.width} height={screen.height}>
        {shown.includes("cuts") ? <CutLines scene={scene} bounds={bounds} screen={screen} /> : null}
        {shown.includes("light") ? <LightLines handles={light_handles(scene, screen)} screen={screen} /> : null}
      </svg>
      {apart(handles_of(scene), rank).map((handle) => (
        <HandleButton key={handle.key} name={handle.key} look={handle.of.kind} behind={handle.behind ?? false} at={handle} low={handle.low} high={handle.high} now={handle.now}
          label={label_of(scene, handle)} said={said_of(scene, handle)}
          grab={() => {
            grabbed.current = handle;
            if (handle.of.kind === "light") picture.light.value = handle.of.index;
          }}
          drag={(to) => drag(handle, to)}
          step={(right, up) => session.change(what(handle), (now) => handle_stepped(now, bounds, handle, right, up))}
          rest={() => session.rest()}
          hold={(on) => set_held((before) => (on ? handle.key : before === handle.key ? "" : before))} />
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
  const eye = eye_of(scene);
  if (!eye) return null;
  const view = { eye, screen };
  return (
    <g>
      <BoxLines {...view} box={box_of(scene, bounds)} />
      {planes_of(scene).map((_, index) => {
        const drawn = drawn_plane(scene, bounds, index);
        if (!drawn) return null;
        return (
          <g key={index}>
            <PlaneShape {...view} polygon={drawn.polygon} />
            <Stroke from={on_screen(eye, screen, drawn.base)} to={on_screen(eye, screen, drawn.tip)} name="handle-normal" />
          </g>
        );
      })}
    </g>
  );
}

function LightLines({ handles, screen }: { readonly handles: readonly Handle[]; readonly screen: Area }) {
  const x = screen.width / 2, y = screen.height / 2;
  return (
    <g>
      <circle class="handle-ball" cx={x} cy={y} r={ball_radius(screen)} />
      {handles.map((handle) => <line key={handle.key} class="handle-ray" x1={handle.x} y1={handle.y} x2={x + 0.55 * (handle.x - x)} y2={y + 0.55 * (handle.y - y)} />)}
    </g>
  );
}

function label_of(scene: Scene, { of }: Handle): string {
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

function said_of(scene: Scene, { of, now }: Handle): string {
  const text = t.settings.picture;
  if (of.kind === "tilt") {
    const plane = planes_of(scene)[of.index];
    return text.towards((plane?.right ?? 0).toFixed(0), (plane?.up ?? 0).toFixed(0));
  }
  if (of.kind === "light") {
    const eye = eye_of(scene), light = scene.lights[of.index];
    const seen = eye && light && seen_direction(light, eye);
    return text.towards((seen?.right ?? 0).toFixed(0), (seen?.up ?? 0).toFixed(0));
  }
  return text.mm(now.toFixed(0));
}
