/** For what does not import it from `texts` yet. */
export { t } from ".";
