import type { Area } from "../../../input/flat";

/** The windows of settings, as plain data: which are open and where each lies. */
export const window_names = ["look", "light", "lens", "cuts"] as const;
export type WindowName = (typeof window_names)[number];

/** Docked: at the side, in the order of opening. Free: its upper left corner, in pixels of the page. */
export type Placement = { readonly docked: true } | { readonly docked: false; readonly x: number; readonly y: number };

export interface Layout {
  readonly open: readonly WindowName[];
  readonly places: Readonly<Partial<Record<WindowName, Placement>>>;
}

export const closed_layout: Layout = { open: [], places: {} };
/** So much of a window stays in the page, so that it can be taken back. */
const least_seen = 80;
/** Of a window's head. */
const head_height = 48;

export const place_in = (layout: Layout, name: WindowName): Placement => layout.places[name] ?? { docked: true };

/** Of a sheet (`narrow`) there is one at a time, and one at the side: what is free stays. */
export function opened(layout: Layout, name: WindowName, narrow: boolean): Layout {
  const stays = (one: WindowName) => one !== name && !narrow && !(place_in(layout, one).docked && place_in(layout, name).docked);
  return { ...layout, open: [...layout.open.filter(stays), name] };
}

export const closed = (layout: Layout, name: WindowName): Layout => ({ ...layout, open: layout.open.filter((one) => one !== name) });

/** Its corner as told, but never out of reach. */
export function moved(layout: Layout, name: WindowName, x: number, y: number, screen: Area): Layout {
  const place: Placement = {
    docked: false,
    x: Math.round(Math.min(Math.max(x, 0), Math.max(0, screen.width - least_seen))),
    y: Math.round(Math.min(Math.max(y, 0), Math.max(0, screen.height - head_height))),
  };
  return { ...layout, places: { ...layout.places, [name]: place } };
}

/** To the side, from where another that is there goes. */
export function docked(layout: Layout, name: WindowName): Layout {
  const open = layout.open.filter((one) => one === name || !place_in(layout, one).docked);
  return { open, places: { ...layout.places, [name]: { docked: true } } };
}

type Store = Pick<Storage, "getItem" | "setItem">;
const key = "diaphane.windows";

/** As it was in this tab; all closed where nothing is known, or what is known is damaged. */
export function remembered_layout(store: Store): Layout {
  try {
    const value = JSON.parse(store.getItem(key) ?? "null") as { open?: unknown; places?: unknown } | null;
    const is_name = (one: unknown): one is WindowName => (window_names as readonly unknown[]).includes(one);
    const open = Array.isArray(value?.open) ? value.open.filter(is_name) : [];
    const places: Partial<Record<WindowName, Placement>> = {};
    const kept = typeof value?.places === "object" && value.places !== null ? (value.places as Record<string, unknown>) : {};
    for (const name of window_names) {
      const place = placement_of(kept[name]);
      if (place) places[name] = place;
    }
    return { open: [...new Set(open)], places };
  } catch {
    return closed_layout;
  }
}

function placement_of(value: unknown): Placement | null {
  if (typeof value !== "object" || value === null) return null;
  const { docked: at_side, x, y } = value as Record<string, unknown>;
  if (at_side === true) return { docked: true };
  return Number.isFinite(x) && Number.isFinite(y) ? { docked: false, x: x as number, y: y as number } : null;
}

export const remember_layout = (store: Store, layout: Layout): void => store.setItem(key, JSON.stringify(layout));
