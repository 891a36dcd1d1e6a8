# What R makes of questionnaires.csv: Rscript questionnaires.R > questionnaires.json
# R 4.2.2. Not run by any test: questionnaires_test.py reads the result.
#
# wilcox.test() has an exact p and an exact interval of differences without ties and zeros only: these are in
# `without_ties`, of made numbers. With ties, the exact p is the share of all 2^n choices of signs whose statistic
# is at least as extreme, and the interval is that of wilcox.test() without ties: qsignrank() places in the sorted
# means of two differences.

here <- dirname(sub("--file=", "", grep("--file=", commandArgs(FALSE), value = TRUE)))
source(file.path(here, "json.R"))

all <- read.csv(file.path(here, "questionnaires.csv"), colClasses = c(participant = "character"))
conditions <- expand.grid(rotation = c("NoR", "R"), haptic = c("NoH", "UaH", "H"), stringsAsFactors = FALSE)
people <- as.character(1:12)
tlx <- c("tlx_mental", "tlx_physical", "tlx_temporal", "tlx_performance", "tlx_effort", "tlx_frustration")

# participants x conditions: sums of the items, each a mean over the blocks, NA if one is missing. Means of two
# blocks are halves, so that nothing is rounded.
sums <- function(items) {
  sapply(seq_len(nrow(conditions)), function(i) {
    at <- all[all$haptic == conditions$haptic[i] & all$rotation == conditions$rotation[i] & all$item %in% items, ]
    vapply(people, function(p) {
      values <- at$value[at$participant == p]
      over_blocks <- tapply(values, at$item[at$participant == p], mean)
      if (length(over_blocks) == length(items)) sum(over_blocks) else NA_real_
    }, 0)
  })
}

exact_p <- function(d) {
  ranks <- rank(abs(d))
  w <- sum(ranks[d > 0])
  signs <- as.matrix(expand.grid(rep(list(0:1), length(d))))
  all_w <- as.vector(signs %*% ranks)
  min(1, 2 * min(mean(all_w <= w), mean(all_w >= w)))
}

walsh <- function(d) {
  means <- outer(d, d, "+") / 2
  sort(means[lower.tri(means, diag = TRUE)])
}

pair <- function(a, b, n_items) {
  d <- na.omit(a - b)
  n <- length(d)
  unequal <- d[d != 0]
  means <- walsh(d)
  place <- qsignrank(0.025, n)
  test <- suppressWarnings(wilcox.test(d, exact = FALSE))
  ranks <- rank(abs(unequal))
  w <- unname(test$statistic)
  list(statistic = w, p = exact_p(unequal), p_normal = test$p.value,
       effect_size = (sum(ranks[unequal > 0]) - sum(ranks[unequal < 0])) / sum(ranks),
       difference = median(means) / n_items, low_95 = means[place] / n_items,
       high_95 = means[n * (n + 1) / 2 - place + 1] / n_items, participants = n, unequal = length(unequal))
}

rating <- function(name, items) {
  x <- sums(items)
  complete <- x[complete.cases(x), ]
  test <- friedman.test(complete)
  chi2 <- unname(test$statistic)
  places <- combn(nrow(conditions), 2, simplify = FALSE)
  label <- paste(conditions$haptic, conditions$rotation, sep = ", ")
  pairs <- lapply(places, function(p) pair(x[, p[2]], x[, p[1]], length(items)))
  holm <- p.adjust(vapply(pairs, function(x) x$p, 0), "holm")
  pairs <- Map(function(p, x, h) c(list(pair = paste(label[p[2]], "-", label[p[1]])), x, list(p_holm = h)),
               places, pairs, holm)
  medians <- lapply(seq_len(ncol(x)), function(i) {
    y <- na.omit(x[, i]) / length(items)
    q <- unname(quantile(y, c(0.25, 0.5, 0.75)))
    list(haptic = conditions$haptic[i], rotation = conditions$rotation[i], n = length(y), median = q[2],
         low_quartile = q[1], high_quartile = q[3], mean = mean(y))
  })
  list(rating = name, friedman = list(statistic = chi2, df = unname(test$parameter), p = test$p.value,
       effect_size = chi2 / (nrow(complete) * (ncol(complete) - 1)), participants = nrow(complete)),
       pairs = unname(pairs), medians = medians)
}

without_ties <- lapply(list(c(1.5, -0.25, 3, 2.125, 4.75, -1), c(-3, 5, -7, 11, -13, 17, -19, 23, 29, -31),
                            c(2, -1.5, 8, 16, 4, 32, 64, 128, 1, 256, 512, 0.75, -6, 7, 9, 21, 33, -65, 77, 100)),
                       function(d) {
  test <- wilcox.test(d, conf.int = TRUE, exact = TRUE)
  list(differences = as.list(d), statistic = unname(test$statistic), p = test$p.value,
       difference = unname(test$estimate), low_95 = test$conf.int[1], high_95 = test$conf.int[2])
})

names <- c("mental demand", "physical demand", "temporal demand", "performance", "effort", "frustration")
ratings <- c(list(rating("raw TLX", tlx), rating("how real", "real")),
             unname(Map(function(name, item) rating(name, item), names, tlx)))
cat(gsub("}, {", "},\n{", json(list(r = R.version.string, without_ties = without_ties, ratings = ratings), 12), fixed = TRUE),
    "\n", sep = "")
