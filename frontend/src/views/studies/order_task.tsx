import { useEffect, useRef, useState } from "preact/hooks";
import { after } from "../../live/paced";
import type { OrderStep } from "../../studies/definition";
import { moved } from "../../studies/order";
import type { Participation } from "../../studies/participation";
import { randomNumbers, shuffled } from "../../studies/random";
import { t } from "../../texts";
import { IconButton } from "../icon_button";
import { Icon } from "../icons";
import { Notice } from "../shell";
import { useApp } from "../state";
import type { Done } from "./answer_forms";

export interface OrderTaskProps {
  readonly step: OrderStep;
  readonly participation: Participation;
  readonly done: Done;
}

const triedAgainMs = 2000;

/** Pictures to put in order: by dragging, by buttons and by keys. */
export function OrderTask({ step, participation, done }: OrderTaskProps) {
  const ids = step.pictures.map(({ id }) => id);
  const [shown] = useState(() => shuffled(ids, randomNumbers(participation.joined.seed, `pictures/${step.id}`)));
  const [order, setOrder] = useState<readonly string[]>(shown);
  const [told, setTold] = useState("");
  const { urls, failing } = usePictures(participation, shown);
  const list = useRef<HTMLOListElement>(null);
  const move = (id: string, to: number) => {
    const next = moved(order, order.indexOf(id), to);
    if (next.every((one, i) => one === order[i])) return;
    setOrder(next);
    setTold(t.takePart.movedTo(shown.indexOf(id) + 1, next.indexOf(id) + 1));
  };
  const grab = useDragging(list, order, move);
  const text = t.takePart;
  return (
    <div class="study-order">
      <p class="muted">{text.orderHint}</p>
      {failing ? <Notice kind="info">{text.picturesFailed}</Notice> : null}
      <p class="study-order-end">{text.least}</p>
      <ol ref={list} aria-label={text.order}>
        {order.map((id, at) => (
          <PictureItem
            key={id}
            number={shown.indexOf(id) + 1}
            at={at}
            all={order.length}
            url={urls.get(id) ?? null}
            move={(to) => move(id, to)}
            grab={(event) => grab(id, event)}
          />
        ))}
      </ol>
      <p class="study-order-end">{text.most}</p>
      <p class="visually-hidden" role="status">
        {told}
      </p>
      <button
        type="button"
        class="button button-main"
        disabled={urls.size < order.length}
        onClick={() => done({ order, shown })}
      >
        {text.myOrder}
      </button>
    </div>
  );
}

interface PictureItemProps {
  readonly number: number;
  readonly at: number;
  readonly all: number;
  readonly url: string | null;
  readonly move: (to: number) => void;
  readonly grab: (event: PointerEvent) => void;
}

function PictureItem({ number, at, all, url, move, grab }: PictureItemProps) {
  const text = t.takePart;
  const item = useRef<HTMLDivElement>(null);
  /** What the participant moved the picture with. A browser drops its focus when the picture moves in the page. */
  const used = useRef<HTMLElement | null>(null);
  useEffect(() => {
    if (used.current) (used.current.matches(":disabled") ? item.current : used.current)?.focus();
    used.current = null;
  }, [at]);
  const moveBy = (by: number) => {
    if (at + by < 0 || at + by >= all) return;
    const { activeElement } = document;
    used.current = activeElement instanceof HTMLElement ? activeElement : null;
    move(at + by);
  };
  const key = (event: KeyboardEvent) => {
    const by = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    moveBy(by);
  };
  return (
    <li data-picture={number}>
      <div
        ref={item}
        class="study-order-picture"
        tabIndex={0}
        role="group"
        aria-label={text.pictureAt(number, at + 1, all)}
        onKeyDown={key}
        onPointerDown={(event) => event.pointerType === "mouse" && grab(event)}
      >
        {url ? <img src={url} alt="" draggable={false} /> : <span class="spinner" />}
        <span class="study-grip" aria-hidden="true" onPointerDown={grab}>
          <Icon name="grip" />
        </span>
      </div>
      <div class="study-order-tools">
        <IconButton icon="left" label={text.earlier(number)} disabled={at === 0} onClick={() => moveBy(-1)} />
        <span aria-hidden="true">{at + 1}</span>
        <IconButton icon="right" label={text.later(number)} disabled={at === all - 1} onClick={() => moveBy(1)} />
      </div>
    </li>
  );
}

type Move = (id: string, to: number) => void;

/** Lets a picture follow the pointer to the place of the nearest one. The window hears it, because the item moves. */
function useDragging(
  list: { readonly current: HTMLOListElement | null },
  order: readonly string[],
  move: Move,
): (id: string, event: PointerEvent) => void {
  const latest = useRef({ order, move });
  latest.current = { order, move };
  const stop = useRef<() => void>(() => undefined);
  useEffect(() => () => stop.current(), []);
  return (id, event) => {
    if (event.button !== 0) return;
    event.preventDefault();
    stop.current();
    const ending = new AbortController();
    stop.current = () => ending.abort();
    const follow = ({ clientX, clientY }: PointerEvent) => {
      const distances = [...(list.current?.children ?? [])].map((item) => {
        const box = item.getBoundingClientRect();
        return Math.hypot(clientX - box.x - box.width / 2, clientY - box.y - box.height / 2);
      });
      const nearest = distances.indexOf(Math.min(...distances));
      if (nearest >= 0 && nearest !== latest.current.order.indexOf(id)) latest.current.move(id, nearest);
    };
    addEventListener("pointermove", follow, { signal: ending.signal });
    for (const end of ["pointerup", "pointercancel"] as const)
      addEventListener(end, () => ending.abort(), { signal: ending.signal });
  };
}

/** Loads the pictures of the step, and tries again while the server is not there. */
function usePictures(participation: Participation, ids: readonly string[]) {
  const { api } = useApp();
  const [urls, setUrls] = useState<ReadonlyMap<string, string>>(new Map());
  const [failing, setFailing] = useState(false);
  useEffect(() => {
    const leaving = new AbortController();
    const made: string[] = [];
    let stopTimer: () => void = () => undefined;
    const isGone = () => leaving.signal.aborted;
    const load = async (id: string): Promise<void> => {
      if (isGone()) return;
      try {
        const url = URL.createObjectURL(await api.studies.pictureOf(participation.key, id, leaving.signal));
        made.push(url);
        setUrls((before) => new Map(before).set(id, url));
        setFailing(false);
      } catch (thrown) {
        if (isGone() || participation.endIfOver(thrown)) return;
        setFailing(true);
        await new Promise<void>((resolve) => (stopTimer = after(triedAgainMs, resolve)));
        await load(id);
      }
    };
    void (async () => {
      for (const id of ids) await load(id);
    })();
    return () => {
      leaving.abort();
      stopTimer();
      for (const url of made) URL.revokeObjectURL(url);
    };
  }, [api, participation, ids]);
  return { urls, failing };
}
