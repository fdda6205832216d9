import { counting } from "../counting";

export const { number, fixed, count } = counting("de");
