# JSON, which base R does not write. Sourced by the scripts of this folder.

json <- function(x, digits = 17) {
  if (is.list(x)) {
    parts <- vapply(x, json, "", digits)
    if (is.null(names(x))) return(paste0("[", paste(parts, collapse = ", "), "]"))
    return(paste0("{", paste0('"', names(x), '": ', parts, collapse = ", "), "}"))
  }
  if (length(x) != 1 || !is.null(names(x))) return(json(as.list(x), digits))
  if (is.character(x)) return(paste0('"', x, '"'))
  if (is.logical(x) && !is.na(x)) return(tolower(as.character(x)))
  if (is.na(x)) return("null")
  sprintf("%.*g", as.integer(digits), x)
}
