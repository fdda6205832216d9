import { useRef, useState } from "preact/hooks";
import { handles_to_take, moved, plane_in_region, range_of, type Handle, type Region } from "../../cut/region";
import { dragged, type Box, type Eye } from "../../picture/project";
import { t } from "../../texts";
import { BoxLines, PlaneShape } from "../picture/box_lines";
import { HandleButton } from "../picture/handle_button";
import { use_screen } from "../picture/use_screen";

export const name_of = (handle: Handle): string => (handle.kind === "plane" ? t.cut.plane : t.cut.faces[handle.axis][handle.side]);
export const key_of = (handle: Handle): string => (handle.kind === "plane" ? "plane" : `${handle.axis}-${handle.side}`);

export interface HandlesProps {
  readonly eye: Eye;
  readonly region: Region;
  readonly bounds: Box;
  readonly change: (region: Region, rest: boolean) => void;
}

/** The box and the plane over the picture, with a handle for each of their faces. */
export function Handles({ eye, region, bounds, change }: HandlesProps) {
  const area = useRef<HTMLDivElement>(null);
  const [held, set_held] = useState<Handle | null>(null);
  const screen = use_screen(area);
  return (
    <div class="handle-area cut-area" ref={area} role="region" aria-label={t.cut.area}>
      <svg aria-hidden="true" width={screen.width} height={screen.height}>
        <BoxLines eye={eye} screen={screen} box={region} />
        <PlaneShape eye={eye} screen={screen} polygon={plane_in_region(region)} />
      </svg>
      {handles_to_take(eye, screen, region, held).map((placed) => {
        const { handle, place, along } = placed;
        const range = range_of(handle, region, bounds);
        return (
          <HandleButton key={key_of(handle)} name={key_of(handle)} label={name_of(handle)} look={handle.kind} at={placed} low={range.low} high={range.high} now={range.at}
            said={t.cut.mm(Math.round(range.at))}
            drag={(to) => {
              const by = dragged(eye, screen, place, along, { x: to.x - placed.x, y: to.y - placed.y });
              if (by !== null) change(moved(handle, range.at + by, region, bounds), false);
            }}
            step={(right, up) => change(moved(handle, range.at + right + up, region, bounds), true)}
            rest={() => change(region, true)}
            hold={(on) => set_held((before) => (on ? handle : before === handle ? null : before))} />
        );
      })}
    </div>
  );
}
