import type { Area } from "../../../input/flat";

/** The windows of settings, as plain data: which are open and where each lies. */
export const windowNames = ["look", "light", "lens", "cuts"] as const;
export type WindowName = (typeof windowNames)[number];

/** Docked: at the side, in the order of opening. Free: its upper left corner, in pixels of the page. */
export type Placement = { readonly docked: true } | { readonly docked: false; readonly x: number; readonly y: number };

export interface Layout {
  readonly open: readonly WindowName[];
  readonly places: Readonly<Partial<Record<WindowName, Placement>>>;
}

export const closedLayout: Layout = { open: [], places: {} };
/** So much of a window stays in the page, so that it can be taken back. */
const leastSeen = 80;
/** Of a window's head. */
const headHeight = 48;

export const placeIn = (layout: Layout, name: WindowName): Placement => layout.places[name] ?? { docked: true };

/** Of a sheet (`narrow`) there is one at a time, and one at the side: what is free stays. */
export function opened(layout: Layout, name: WindowName, narrow: boolean): Layout {
  const stays = (one: WindowName) =>
    one !== name && !narrow && !(placeIn(layout, one).docked && placeIn(layout, name).docked);
  return { ...layout, open: [...layout.open.filter(stays), name] };
}

export const closed = (layout: Layout, name: WindowName): Layout => ({
  ...layout,
  open: layout.open.filter((one) => one !== name),
});

/** Its corner as told, but never out of reach. */
export function moved(layout: Layout, name: WindowName, x: number, y: number, screen: Area): Layout {
  const place: Placement = {
    docked: false,
    x: Math.round(Math.min(Math.max(x, 0), Math.max(0, screen.width - leastSeen))),
    y: Math.round(Math.min(Math.max(y, 0), Math.max(0, screen.height - headHeight))),
  };
  return { ...layout, places: { ...layout.places, [name]: place } };
}

/** To the side, from where another that is there goes. */
export function docked(layout: Layout, name: WindowName): Layout {
  const open = layout.open.filter((one) => one === name || !placeIn(layout, one).docked);
  return { open, places: { ...layout.places, [name]: { docked: true } } };
}

type Store = Pick<Storage, "getItem" | "setItem">;
const key = "diaphane.windows";

/** As it was in this tab; all closed where nothing is known, or what is known is damaged. */
export function rememberedLayout(store: Store): Layout {
  try {
    const value = JSON.parse(store.getItem(key) ?? "null") as { open?: unknown; places?: unknown } | null;
    const isName = (one: unknown): one is WindowName => (windowNames as readonly unknown[]).includes(one);
    const open = Array.isArray(value?.open) ? value.open.filter(isName) : [];
    const places: Partial<Record<WindowName, Placement>> = {};
    const kept =
      typeof value?.places === "object" && value.places !== null ? (value.places as Record<string, unknown>) : {};
    for (const name of windowNames) {
      const place = placementOf(kept[name]);
      if (place) places[name] = place;
    }
    return { open: [...new Set(open)], places };
  } catch {
    return closedLayout;
  }
}

function placementOf(value: unknown): Placement | null {
  if (typeof value !== "object" || value === null) return null;
  const { docked: atSide, x, y } = value as Record<string, unknown>;
  if (atSide === true) return { docked: true };
  return Number.isFinite(x) && Number.isFinite(y) ? { docked: false, x: x as number, y: y as number } : null;
}

export const rememberLayout = (store: Store, layout: Layout): void => store.setItem(key, JSON.stringify(layout));
