import { useRef } from "preact/hooks";
import { OverlayMode, setSplit } from "../../scene/overlay";
import { t } from "../../texts";
import type { ViewerSession } from "../../video/viewer_session";

const step = 0.02;

/** The line between the first and the second scan, which is dragged in the picture or moved with the arrow keys. */
export function Divider({ session }: { readonly session: ViewerSession }) {
  const area = useRef<HTMLDivElement>(null);
  const { editor } = session;
  const overlay = editor.scene.value?.overlay;
  if (!session.second.value || overlay?.mode !== OverlayMode.SPLIT) return null;
  const { split } = overlay;
  const move = (to: number) => editor.change("overlay split", (scene) => setSplit(scene, to), true);
  const drag = (event: PointerEvent) => {
    const box = area.current?.getBoundingClientRect();
    const held = event.currentTarget instanceof Element && event.currentTarget.hasPointerCapture(event.pointerId);
    if (box && box.width > 0 && held) move((event.clientX - box.left) / box.width);
  };
  const key = (event: KeyboardEvent) => {
    const to = { ArrowLeft: split - step, ArrowRight: split + step, Home: 0, End: 1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    move(to);
  };
  return (
    <div class="handle-area" ref={area}>
      <div
        class="divider"
        style={{ left: `${100 * split}%` }}
        role="slider"
        tabIndex={0}
        aria-label={t.compare.overlay.divider}
        aria-orientation="horizontal"
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={Math.round(100 * split)}
        aria-valuetext={t.compare.overlay.dividerText(split)}
        onPointerDown={(event) => {
          if (event.button === 0) event.currentTarget.setPointerCapture(event.pointerId);
        }}
        onPointerMove={drag}
        onPointerUp={() => editor.rest()}
        onPointerCancel={() => editor.rest()}
        onKeyDown={key}
        onKeyUp={() => editor.rest()}
      />
    </div>
  );
}
